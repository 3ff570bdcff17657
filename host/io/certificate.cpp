#include "host/io/certificate.h"

#include <chrono>
#include <cstdio>
#include <stdexcept>

#include "host/io/certificate_keys.h"
#include "host/io/model_io.h"
#include "host/io/number_text.h"
#include "host/io/toml_text.h"
#include "host/io/whole_file.h"

namespace stria {
namespace {

constexpr CertificateStatus kStatuses[] = {CertificateStatus::passed, CertificateStatus::failed,
                                           CertificateStatus::unchecked};

std::optional<std::chrono::sys_days> day_of(const std::string& text) {
    int year = 0;
    unsigned month = 0, day = 0;
    char rest = 0;
    if (text.size() != 10 ||
        std::sscanf(text.c_str(), "%4d-%2u-%2u%c", &year, &month, &day, &rest) != 3)
        return std::nullopt;
    const std::chrono::year_month_day date{std::chrono::year{year}, std::chrono::month{month},
                                           std::chrono::day{day}};
    if (!date.ok()) return std::nullopt;
    return std::chrono::sys_days{date};
}

std::string read_day(TomlTable& table, const std::string& key) {
    const std::string text = table.text(key, "");
    if (!text.empty() && !day_of(text))
        table.refuse(key, "expected a day as \"2031-12-24\" or \"\", found '" + text + "'");
    return text;
}

double read_share(TomlTable& table, const std::string& key) {
    const double value = table.number(key, 1.0);
    if (!(value >= 0 && value <= 1)) table.refuse(key, "expected 0 to 1");
    return value;
}

double read_length(TomlTable& table, const std::string& key) {
    const double value = table.number(key, 0.0);
    if (!(value >= 0)) table.refuse(key, "expected 0 or more");
    return value;
}

int read_count(TomlTable& table, const std::string& key) {
    const std::int64_t value = table.integer(key, 0);
    if (value < 0 || value > 1'000'000) table.refuse(key, "expected 0 to 1000000");
    return static_cast<int>(value);
}

}  // namespace

const char* name_of(CertificateStatus status) {
    switch (status) {
        case CertificateStatus::passed:
            return "passed";
        case CertificateStatus::failed:
            return "failed";
        case CertificateStatus::unchecked:
            return "unchecked";
    }
    return "";
}

Certificate read_certificate_keys(TomlTable& table) {
    Certificate certificate;
    const std::string status = table.text("status");
    bool known = false;
    for (const CertificateStatus kind : kStatuses)
        if (status == name_of(kind)) {
            certificate.status = kind;
            known = true;
        }
    if (!known)
        table.refuse("status", "expected passed, failed or unchecked, found '" + status + "'");
    if (table.has("reasons")) certificate.reasons = table.texts("reasons");
    certificate.date = read_day(table, "date");
    certificate.expires = read_day(table, "expires");
    if (table.has("temperature_c")) certificate.temperature_c = table.number("temperature_c");
    certificate.data_hash = table.text("data_hash", "");
    certificate.check_hash = table.text("check_hash", "");
    certificate.views = read_count(table, "views");
    certificate.check_views = read_count(table, "check_views");
    certificate.precision_mm = read_length(table, "precision_mm");
    certificate.trueness_mm = read_length(table, "trueness_mm");
    certificate.expected_trueness_mm = read_length(table, "expected_trueness_mm");
    certificate.check_p_value = read_share(table, "check_p_value");
    certificate.cross_p_value = read_share(table, "cross_p_value");
    certificate.model_error_px = read_length(table, "model_error_px");
    return certificate;
}

std::optional<Certificate> parse_certificate(const std::string& text, const std::string& name) {
    TomlTable top = parse_toml(text, name);
    auto table = top.find_table("certificate");
    if (!table) return std::nullopt;
    Certificate certificate = read_certificate_keys(*table);
    table->finish();
    return certificate;
}

std::optional<Certificate> read_certificate(const std::string& path) {
    return parse_certificate(read_whole_file(path, std::size_t{64} << 20), path);
}

std::string format_certificate(const Certificate& certificate) {
    std::string text = "[certificate]\n" + toml_line("status", name_of(certificate.status));
    text += "reasons = [";
    for (std::size_t i = 0; i < certificate.reasons.size(); ++i)
        text += (i > 0 ? ", " : "") + toml_text(certificate.reasons[i]);
    text += "]\n" + toml_line("date", certificate.date) + toml_line("expires", certificate.expires);
    if (certificate.temperature_c) text += toml_line("temperature_c", *certificate.temperature_c);
    text += toml_line("data_hash", certificate.data_hash) +
            toml_line("check_hash", certificate.check_hash);
    text += "views = " + std::to_string(certificate.views) +
            "\ncheck_views = " + std::to_string(certificate.check_views) + "\n";
    return text + toml_line("precision_mm", certificate.precision_mm) +
           toml_line("trueness_mm", certificate.trueness_mm) +
           toml_line("expected_trueness_mm", certificate.expected_trueness_mm) +
           toml_line("check_p_value", certificate.check_p_value) +
           toml_line("cross_p_value", certificate.cross_p_value) +
           toml_line("model_error_px", certificate.model_error_px) + "\n";
}

void write_scanner(const std::string& path, const ScannerModel& model,
                   const std::optional<Certificate>& certificate) {
    write_whole_file(path,
                     format_scanner(model) + (certificate ? format_certificate(*certificate) : ""));
}

std::string certificate_warning(const std::optional<Certificate>& certificate,
                                const ScannerModel& model, const std::string& today) {
    if (!certificate)
        return "the calibration has no certificate: nothing checked it independently (stria "
               "calibrate scanner does)";
    const std::string why = certificate->reasons.empty() ? "" : ": " + certificate->reasons.front();
    if (certificate->status == CertificateStatus::failed)
        return "the calibration's certificate says it failed" + why;
    if (certificate->data_hash != model.provenance.data_hash)
        return "the certificate is for the calibration from data " + certificate->data_hash +
               ", the model comes from data " + model.provenance.data_hash;
    if (certificate->status == CertificateStatus::unchecked)
        return "the calibration was not checked independently" + why;
    const auto until = day_of(certificate->expires), now = day_of(today);
    if (until && now && *now > *until)
        return "the calibration's certificate of " + certificate->date + " expired on " +
               certificate->expires + ": calibrate again";
    return "";
}

std::string days_after(const std::string& day, int days) {
    const auto start = day_of(day);
    if (!start) throw std::invalid_argument("day = '" + day + "': expected as 2031-12-24");
    const std::chrono::year_month_day end{*start + std::chrono::days{days}};
    char text[32];
    std::snprintf(text, sizeof text, "%04d-%02u-%02u", int(end.year()), unsigned(end.month()),
                  unsigned(end.day()));
    return text;
}

}  // namespace stria
