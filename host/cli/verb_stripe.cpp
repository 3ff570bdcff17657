#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "firmware/stripe/deconvolution.h"
#include "firmware/stripe/spacetime.h"
#include "firmware/stripe/spatial.h"
#include "host/cli/progress.h"
#include "host/cli/stripe_input.h"
#include "host/cli/stripe_profile.h"
#include "host/cli/verbs.h"
#include "host/core/errors.h"
#include "host/geometry/parallel.h"
#include "host/io/number_text.h"
#include "host/io/whole_file.h"
#include "host/render/stripe_picture.h"

namespace stria {
namespace {

std::string number(double value, const char* format = "%.9g") {
    char text[32];
    std::snprintf(text, sizeof text, format, value);
    return text;
}

/// A CSV field: quoted where it must be.
std::string field(const std::string& text) {
    if (text.find_first_of(",\"\n") == std::string::npos) return text;
    std::string out = "\"";
    for (const char c : text) {
        if (c == '"') out += '"';
        out += c;
    }
    return out + '"';
}

class StripeVerb final : public Verb {
  public:
    std::string name() const override { return "stripe"; }
    std::string summary() const override {
        return "find the stripe in images: peaks in each, or pulses over time";
    }

    void declare(Arguments& arguments) override {
        arguments.positional("IMAGES", files_, "images in the order they were taken");
        arguments.choice("--mode", mode_, {"spatial", "spacetime"},
                         "peaks in every image, or pulses of every pixel over the images");
        arguments.choice("--method", method_, method_names(),
                         "spatial: how a peak is placed: maximum likelihood, centre of gravity, "
                         "log-parabola, Blais-Rioux, matched filter, Steger");
        arguments.option("--out", out_, "CSV file to write", true);
        arguments.choice("--axis", axis_, {"rows", "columns"},
                         "spatial: one peak a row, or one a column");
        arguments.option("--times", times_, "one number a line, one line an image (spacetime)");
        arguments.choice("--channel", channel_, {"auto", "red", "green", "blue", "grey"},
                         "which channel of colour images");
        arguments.option(
            "--off", off_,
            "spatial: images without laser, subtracted: as many as IMAGES, one each in "
            "their order, or else their mean");
        arguments.option("--deconvolve", deconvolve_,
                         "spacetime: FOOTPRINT,TARGET in px (standard deviations): sharpen what a "
                         "pixel sees across the stripe, against errors at edges of reflectance, at "
                         "the price of noise; 0.8,0.55 more than doubles it");
        arguments.flag("--fast", fast_,
                       "spacetime, images of 8 bits: the scanner's SIMD kernels; what they find is "
                       "the same to a tenth of a sigma");
        arguments.flag("--any-colour", any_colour_,
                       "spatial: keep peaks of colour images that have not the laser's colour");
        arguments.option("--noise", noise_,
                         "GAIN,READ of the sensor: electrons per DN, electrons; else estimated");
        arguments.option("--min-snr", min_snr_, "least height over the noise of the background");
        arguments.option("--min-amplitude", min_amplitude_,
                         "least height in DN; spatial, 0: 15 % of the upper quartile of all peaks");
        arguments.option("--max-width", max_width_, "widest stripe (px, standard deviation)");
        arguments.option("--min-run", min_run_,
                         "spatial: drop peaks without a chain of so many rows through them");
        arguments.option("--overlay", overlay_, "folder for PNGs with what was found drawn in");
    }

    int run(const Context& context) override {
        context.check_output(out_);
        check_method();
        StripeImages images(files_, {channel_, axis_ == "columns", off_, times_});
        noise_model_ =
            noise_.empty() ? images.estimated_noise() : images.noise_of(parse_noise(noise_));
        if (!overlay_.empty()) std::filesystem::create_directories(overlay_);
        context.say("noise: " + number(1.0 / noise_model_.gain_e_per_dn, "%.3g") +
                    " DN^2 a DN of light, " +
                    number(noise_model_.read_noise_e / noise_model_.gain_e_per_dn, "%.3g") +
                    " DN without" + (noise_.empty() ? " (estimated)" : ""));
        return mode_ == "spatial" ? run_spatial(context, images) : run_spacetime(context, images);
    }

  private:
    static std::vector<std::string> method_names() {
        std::vector<std::string> names;
        for (const PeakMethod method : kPeakMethods) names.emplace_back(name_of(method));
        return names;
    }

    void check_method() const {
        if (mode_ == "spatial" && !deconvolve_.empty())
            throw Error(
                "--deconvolve: expected --mode spacetime; in one image it ties the noise of "
                "neighbouring pixels together, and a peak's sigma would not be true");
        if (fast_ && (mode_ == "spatial" || !deconvolve_.empty()))
            throw Error("--fast: expected --mode spacetime without --deconvolve");
        if (mode_ == "spacetime" && !off_.empty())
            throw Error(
                "--off: expected --mode spatial; over time every pixel's own background is fitted "
                "with its pulse");
        if (mode_ == "spacetime" && method_ != "ml")
            throw Error("--method " + method_ +
                        ": expected ml with --mode spacetime, whose pulses are fitted over time; "
                        "the other methods place peaks of single images (--mode spatial)");
    }

    int run_spatial(const Context& context, StripeImages& images) {
        SpatialOptions options;
        options.min_snr = min_snr_;
        options.max_width_px = max_width_;
        options.method = peak_method_from(method_).value();  // one of method_names()
        options.min_run_rows = min_run_;
        options.threads = thread_count();
        if (min_amplitude_ > 0) options.min_amplitude_dn = min_amplitude_;
        std::vector<std::vector<Pulse>> found(images.size());
        Progress progress(context, "peaks", images.size(), "images");
        int rows = 0;
        for (std::size_t i = 0; i < images.size(); ++i) {
            const StripeImage image = images.load(i);
            found[i] = peaks_in(image, options);
            for (Pulse& peak : found[i])
                if (image.clipped(peak)) peak.flags |= kPulseSaturated;
            rows = image.frame.height;
            progress.update(i + 1);
        }
        if (min_amplitude_ == 0) drop_faint(found);

        std::string csv = "file,u,v,amplitude,width_px,sigma_px,flags\n";
        std::size_t peaks = 0;
        StripeProfile profile(rows);
        for (std::size_t i = 0; i < images.size(); ++i) {
            if (!overlay_.empty()) draw_overlay(images.file(i), images.load(i).frame, found[i]);
            for (const Pulse& p : found[i]) {
                csv += peak_line(images.file(i), p);
                profile.add(p);
            }
            peaks += found[i].size();
        }
        write_whole_file(out_, csv);
        context.say(std::to_string(peaks) + " peaks in " + std::to_string(images.size()) +
                    " images -> " + out_);
        context.say(profile.table(axis_, "px"));
        if (4 * peaks < images.size() * static_cast<std::size_t>(rows))
            say_if_turned(context, images, options);
        JsonResult result = start_result(false);
        result.set("peaks", peaks).set("along_stripe", profile.json());
        context.finish(result);
        return 0;
    }

    std::vector<Pulse> peaks_in(const StripeImage& image, SpatialOptions options) const {
        if (!any_colour_)
            options.accept = [&](const Pulse& peak) { return image.colour.has(peak); };
        return find_peaks(image.frame, noise_model_, options);
    }

    /// Few peaks: looks at the middle image the other way.
    void say_if_turned(const Context& context, StripeImages& images,
                       const SpatialOptions& options) const {
        const std::size_t middle = images.size() / 2;
        const std::string other = axis_ == "rows" ? "columns" : "rows";
        std::vector<std::string> off = off_;
        if (off.size() == files_.size()) off = {off_[middle]};
        StripeImages turned({files_[middle]}, {channel_, other == "columns", off, {}});
        const StripeImage image = turned.load(0);
        const std::size_t there = peaks_in(image, options).size();
        const std::size_t here = peaks_in(images.load(middle), options).size();
        if (there > 3 * here && 4 * there > static_cast<std::size_t>(image.frame.height))
            context.say("the stripe seems to run along the " + axis_ + ": --axis " + other +
                        " finds " + std::to_string(there) + " peaks in " + files_[middle] +
                        ", --axis " + axis_ + " " + std::to_string(here));
    }

    int run_spacetime(const Context& context, StripeImages& images) {
        SpacetimeOptions options;
        options.min_snr = min_snr_;
        if (min_amplitude_ > 0) options.min_amplitude_dn = min_amplitude_;
        options.threads = thread_count();
        Progress progress(context, "pulses", images.size(), "images");
        Frame frame = images.load(0).frame;
        if (fast_ && frame.bits > 8)
            throw Error("--fast: expected images of 8 bits, found " + std::to_string(frame.bits));
        options.fast = fast_;
        const std::optional<RowDeconvolver> sharpen = deconvolver(context, frame.bits);
        if (sharpen) options.min_amplitude_dn *= sharpen->scale();
        SpacetimeAnalyser analyser(frame.width, frame.height, sharpen ? 16 : frame.bits,
                                   sharpen ? sharpen->noise_of(noise_model_) : noise_model_,
                                   options);
        for (std::size_t i = 0; i < images.size(); ++i) {
            if (i > 0) frame = images.load(i).frame;
            analyser.add(sharpen ? (*sharpen)(frame) : frame);
            progress.update(i + 1);
        }
        PulseMap map = analyser.finish();
        JsonResult result = start_result(map.undersampled);
        if (sharpen) {
            for (Pulse& p : map.pulses) p.amplitude /= static_cast<float>(sharpen->scale());
            result.set("noise_gain", sharpen->noise_gain());
        }
        result.set("pulses", map.pulses.size());
        if (map.undersampled) {
            const SweepSampling& s = analyser.sampling();
            result.set("step_px", s.step_px).set("width_px", s.width_px);
            std::fprintf(stderr,
                         "stria stripe: undersampled: the stripe moves %.1f px from image to image "
                         "(median) but is only %.1f px wide (standard deviation), so that a pixel "
                         "sees it in %.1f images; no pulse is claimed. Expected a step of at most "
                         "the width: take images more densely, or use --mode spatial\n",
                         s.step_px, s.width_px, s.samples_per_pulse);
            context.finish(result);
            return 1;
        }
        write_whole_file(out_, pulse_csv(map, images));
        if (!overlay_.empty()) write_png(overlay_ + "/pulses.png", picture_of_pulses(map));
        context.say(std::to_string(map.pulses.size()) + " pulses over " +
                    std::to_string(map.frames) + " images -> " + out_);
        StripeProfile profile(frame.height);
        for (const Pulse& p : map.pulses) profile.add(p);
        context.say(
            profile.table(axis_, times_.empty() ? "frames" : "of s", images.units_per_ns()));
        result.set("along_stripe", profile.json(images.units_per_ns()));
        context.finish(result);
        return 0;
    }

    /// What --deconvolve asks for, and what it costs.
    std::optional<RowDeconvolver> deconvolver(const Context& context, int bits) const {
        if (deconvolve_.empty()) return std::nullopt;
        const std::size_t comma = deconvolve_.find(',');
        const auto footprint = parse_number(deconvolve_.substr(0, comma));
        const auto target =
            comma == std::string::npos ? std::nullopt : parse_number(deconvolve_.substr(comma + 1));
        if (!footprint || !target)
            throw Error("--deconvolve: expected FOOTPRINT,TARGET (px), as 0.8,0.55; found " +
                        deconvolve_);
        const RowDeconvolver sharpen({*footprint, *target}, bits);
        context.say("deconvolution: footprint " + number(*footprint, "%.3g") + " -> " +
                    number(*target, "%.3g") + " px, noise times " +
                    number(sharpen.noise_gain(), "%.3g"));
        return sharpen;
    }

    std::string pulse_csv(const PulseMap& map, const StripeImages& images) const {
        const bool columns = axis_ == "columns";
        std::string csv = "u,v,s,amplitude,width_s,sigma_s,flags\n";
        for (const Pulse& p : map.pulses) {
            csv += number(columns ? p.v : p.u) + ',' + number(columns ? p.u : p.v) + ',' +
                   number(images.time_of(static_cast<double>(p.t_ns)), "%.12g") + ',' +
                   number(p.amplitude, "%.6g") + ',' +
                   number(p.width * images.units_per_ns(), "%.6g") + ',' +
                   number(p.sigma * images.units_per_ns(), "%.6g") + ',' + std::to_string(p.flags) +
                   '\n';
        }
        return csv;
    }

    /// Photographs show bright and dark things as well as the stripe, most of them far fainter.
    static void drop_faint(std::vector<std::vector<Pulse>>& found) {
        std::vector<float> amplitudes;
        for (const auto& peaks : found)
            for (const Pulse& p : peaks) amplitudes.push_back(p.amplitude);
        if (amplitudes.empty()) return;
        const auto quartile = amplitudes.begin() + static_cast<long>(amplitudes.size() * 3 / 4);
        std::nth_element(amplitudes.begin(), quartile, amplitudes.end());
        const float least = 0.15f * *quartile;
        for (auto& peaks : found)
            std::erase_if(peaks, [&](const Pulse& p) { return p.amplitude < least; });
    }

    std::string peak_line(const std::string& file, const Pulse& p) const {
        const bool columns = axis_ == "columns";
        return field(file) + ',' + number(columns ? p.v : p.u) + ',' + number(columns ? p.u : p.v) +
               ',' + number(p.amplitude, "%.6g") + ',' + number(p.width, "%.6g") + ',' +
               number(p.sigma, "%.6g") + ',' + std::to_string(p.flags) + '\n';
    }

    void draw_overlay(const std::string& file, const Frame& frame,
                      const std::vector<Pulse>& peaks) const {
        const bool columns = axis_ == "columns";
        const std::string stem = std::filesystem::path(file).stem().string();
        write_png(overlay_ + "/" + stem + ".png", picture_of_peaks(frame, peaks, columns));
    }

    JsonResult start_result(bool undersampled) const {
        JsonResult result;
        result.set("mode", mode_).set("method", method_).set("undersampled", undersampled);
        result.set("gain_e_per_dn", noise_model_.gain_e_per_dn);
        result.set("read_noise_e", noise_model_.read_noise_e);
        return result;
    }

    std::vector<std::string> files_;
    std::string mode_ = "spatial", method_ = "ml", out_, axis_ = "rows", times_, channel_ = "auto",
                noise_, overlay_, deconvolve_;
    std::vector<std::string> off_;
    bool any_colour_ = false, fast_ = false;
    double min_snr_ = 6.0, min_amplitude_ = 0.0, max_width_ = 12.0;
    int min_run_ = 5;
    SensorNoise noise_model_;
};

}  // namespace

std::unique_ptr<Verb> make_stripe_verb() { return std::make_unique<StripeVerb>(); }

}  // namespace stria
