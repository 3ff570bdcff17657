#include "host/io/certificate.h"

#include <gtest/gtest.h>

#include <stdexcept>

#include "host/core/errors.h"
#include "host/io/model_io.h"
#include "tests/host/io/temporary_folder.h"

namespace stria {
namespace {

Certificate some_certificate() {
    Certificate certificate;
    certificate.status = CertificateStatus::failed;
    certificate.reasons = {"points are off by \"0.1 mm\"", "second"};
    certificate.date = "2031-01-31";
    certificate.expires = "2031-05-01";
    certificate.temperature_c = 21.5;
    certificate.data_hash = "00c0ffee";
    certificate.check_hash = "0badf00d";
    certificate.views = 12;
    certificate.check_views = 3;
    certificate.precision_mm = 0.0123456789012345;
    certificate.trueness_mm = 1.0 / 3;
    certificate.expected_trueness_mm = 2e-3;
    certificate.check_p_value = 0.25;
    certificate.cross_p_value = 1e-300;
    certificate.model_error_px = 0.07;
    return certificate;
}

ScannerModel rail_model() {
    ScannerModel model;
    model.channels.resize(1);
    Channel& channel = model.channels[0];
    channel.camera = {.kind = LensKind::pinhole,
                      .width = 640,
                      .height = 480,
                      .fx = 700,
                      .fy = 700,
                      .cx = 320,
                      .cy = 240};
    channel.sheet.offset_mm = 100;
    channel.sheet.apex = Eigen::Vector3d(100, 0, 0);
    channel.axis.kind = MachineKind::rail;
    model.provenance.data_hash = "00c0ffee";
    return model;
}

std::string refusal_of(const std::string& text) {
    try {
        parse_certificate(text, "s.toml");
    } catch (const Error& error) {
        return error.what();
    }
    return "";
}

TEST(Certificate, RoundTripIsExactAndLeavesTheModelAlone) {
    const TemporaryFolder folder;
    const Certificate made = some_certificate();
    const ScannerModel model = rail_model();
    write_scanner(folder / "scanner.toml", model, made);
    const auto back = read_certificate(folder / "scanner.toml");
    ASSERT_TRUE(back);
    EXPECT_EQ(format_certificate(*back), format_certificate(made));
    EXPECT_EQ(back->status, made.status);
    EXPECT_EQ(back->reasons, made.reasons);
    EXPECT_EQ(back->temperature_c, made.temperature_c);
    EXPECT_EQ(back->trueness_mm, made.trueness_mm);
    EXPECT_EQ(back->cross_p_value, made.cross_p_value);
    EXPECT_EQ(format_scanner(read_scanner(folder / "scanner.toml")), format_scanner(model));
    write_scanner(folder / "bare.toml", model, std::nullopt);
    EXPECT_FALSE(read_certificate(folder / "bare.toml"));
}

TEST(Certificate, RefusesWhatIsWrongWithItsPlace) {
    const std::string good = format_certificate(some_certificate());
    const auto with = [&](const std::string& what, const std::string& by) {
        std::string text = good;
        text.replace(text.find(what), what.size(), by);
        return refusal_of(text);
    };
    EXPECT_EQ(refusal_of(good), "");
    EXPECT_NE(with("\"failed\"", "\"good\"").find("line 2"), std::string::npos);
    EXPECT_NE(with("2031-05-01", "2031-02-30").find("expires"), std::string::npos);
    EXPECT_NE(with("precision_mm = ", "precision_mm = -").find("0 or more"), std::string::npos);
    EXPECT_NE(with("check_p_value = 0.25", "check_p_value = 1.5").find("0 to 1"),
              std::string::npos);
    EXPECT_NE(with("check_views", "check_view").find("check_view"), std::string::npos);
    EXPECT_NE(with("views = 12", "views = -1").find("views"), std::string::npos);
}

TEST(Certificate, WarnsOfWhatItSays) {
    const ScannerModel model = rail_model();
    const auto warning = [&](const std::optional<Certificate>& certificate) {
        return certificate_warning(certificate, model, "2031-03-01");
    };
    EXPECT_NE(warning(std::nullopt).find("no certificate"), std::string::npos);
    Certificate certificate = some_certificate();
    EXPECT_NE(warning(certificate).find("failed: points are off"), std::string::npos);
    certificate.status = CertificateStatus::unchecked;
    EXPECT_NE(warning(certificate).find("not checked"), std::string::npos);
    certificate.status = CertificateStatus::passed;
    EXPECT_EQ(warning(certificate), "");
    certificate.expires = "2031-03-01";  // its last day
    EXPECT_EQ(warning(certificate), "");
    certificate.expires = "2031-02-28";
    EXPECT_NE(warning(certificate).find("expired on 2031-02-28"), std::string::npos);
    certificate.expires = "";  // made from a seed
    EXPECT_EQ(warning(certificate), "");
    certificate.data_hash = "11111111";
    EXPECT_NE(warning(certificate).find("11111111"), std::string::npos);
}

TEST(Certificate, CountsDaysByTheCalendar) {
    EXPECT_EQ(days_after("2031-12-31", 1), "2032-01-01");
    EXPECT_EQ(days_after("2032-02-28", 1), "2032-02-29");  // a leap year
    EXPECT_EQ(days_after("2031-01-31", 90), "2031-05-01");
    EXPECT_THROW(days_after("2031-13-01", 1), std::invalid_argument);
    EXPECT_THROW(days_after("soon", 1), std::invalid_argument);
}

}  // namespace
}  // namespace stria
