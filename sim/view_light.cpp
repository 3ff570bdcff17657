#include "sim/view_light.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "host/geometry/parallel.h"
#include "sim/bounce_light.h"
#include "sim/lens.h"
#include "sim/mirror_light.h"

namespace stria {
namespace {

constexpr int kBlockRows = 32;
constexpr int kCells = 4;         ///< a side where a pixel is uneven
constexpr double kCrease = 0.25;  ///< second difference of the crossing, beam sigmas
constexpr int kMostParts = 16;
constexpr double kBesidePixels = 6;  ///< of the sheet within which a pixel is looked at closely

constexpr int kCountedRays = 16;  ///< a pixel, where it is not cut

/// Place of one of 16 rays: each column and each row of the pixel's sixteenths holds one.
Eigen::Vector2d stratum(int i) {
    const int column = i % 4, row = i / 4;
    return {(column + (row + 0.5) / 4) / 4 - 0.5, (row + (column + 0.5) / 4) / 4 - 0.5};
}

Scene without_objects(Scene scene) {
    scene.objects.clear();
    scene.views.clear();
    return scene;
}

}  // namespace

/// The axis position a picture belongs to, and how far the axis moves while it is taken.
struct ViewLight::Moment {
    double s = 0, travel = 0;
    HeadPose head;
    const Beam* beam = nullptr;  ///< the line, or one of its ghosts
};

/// One ray a pixel.
struct ViewLight::Picture {
    std::vector<RayLight> lights;
    std::vector<LightShape> shapes;  ///< empty: all plain
};

ViewLight::ViewLight(const Scene& scene, const SceneGeometry& geometry, std::uint64_t seed,
                     const PixelSampling& sampling)
    : geometry_(geometry),
      sampling_(sampling),
      is_swept_(scene.channel.axis.kind == MachineKind::swept),
      optics_(without_objects(scene)),
      is_blurred_(is_blurred(scene.lens)),
      width_(scene.channel.camera.width),
      height_(scene.channel.camera.height),
      rays_(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_)) {
    beams_.emplace_back(scene);
    if (scene.line.ghost > 0)
        for (int order : {-1, 1}) beams_.emplace_back(scene, order);
    if (scene.speckle.model == SpeckleModel::surface) speckle_.emplace(scene.speckle, seed);
    const auto width = static_cast<std::size_t>(width_);
    parallel_for_blocks(rays_.size(), 4 * width, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            rays_[i] = ray_through(scene.channel.camera, {static_cast<double>(i % width),
                                                          static_cast<double>(i / width)});
    });
}

std::vector<LightBlock> ViewLight::whole_sweep() const {
    return collect({0, 0, head_pose(beams_[0].channel(), 0), nullptr});
}

std::vector<LightBlock> ViewLight::around(double s, double travel) const {
    return collect({s, travel, head_pose(beams_[0].channel(), s), nullptr});
}

RayLight ViewLight::judge(const SurfaceHit& hit, const Moment& moment, double guess,
                          LightShape& shape) const {
    RayLight light;
    light.object = static_cast<std::int16_t>(hit.object);
    light.judged = hit.object < 0;  // nothing there: known to be dark
    if (light.judged) return light;
    light.ambient = static_cast<float>(moment.beam->ambient_rate()) * hit.albedo;
    if (is_blurred_)
        light.spot = SpotSpread::index_of(
            spot_sigma_px(optics_, (moment.head.camera_from_world * hit.point).z()));

    BeamAtPoint beam;
    if (is_swept_) {
        const auto passing = moment.beam->passing(hit, guess);
        light.judged = true;
        if (!passing) return light;
        beam = *passing;
    } else {
        beam = moment.beam->beside(hit, moment.head, std::max(moment.travel, 1e-12), kBesidePixels);
        light.judged = beam.is_near;
    }
    shape = beam.shape;
    light.position = beam.position;
    light.per_position = static_cast<float>(beam.per_position);
    light.per_s = static_cast<float>(beam.per_s);
    if (light.judged && beam.rate > 0 && !geometry_.is_occluded(hit, beam.light_in_world))
        light.rate = static_cast<float>(beam.rate);
    if (speckle_ && light.rate > 0)
        light.speckle =
            static_cast<float>(speckle_->at(hit.object, geometry_.point_in_object(hit)));
    return light;
}

void ViewLight::first_rays(const Moment& moment, int row, Picture& picture) const {
    const auto width = static_cast<std::size_t>(width_);
    std::vector<Eigen::Vector3d> directions(width);
    std::vector<SurfaceHit> hits(width);
    for (std::size_t x = 0; x < width; ++x)
        directions[x] = moment.head.world_from_camera.rotation *
                        rays_[static_cast<std::size_t>(row) * width + x];
    geometry_.first_hits(moment.head.world_from_camera.translation, directions, hits);
    const std::size_t first = static_cast<std::size_t>(row) * width;
    RayLight* const lights = &picture.lights[first];
    LightShape plain;
    double guess = 0;
    for (std::size_t x = 0; x < width; ++x) {
        lights[x] = judge(hits[x], moment, guess,
                          picture.shapes.empty() ? plain : picture.shapes[first + x]);
        if (is_swept_ && lights[x].per_s > 0) guess = lights[x].position;
    }
}

bool ViewLight::is_uneven(const std::vector<RayLight>& image, int x, int y) const {
    const auto at = [&](int i, int j) -> const RayLight& {
        return image[static_cast<std::size_t>(std::clamp(j, 0, height_ - 1)) *
                         static_cast<std::size_t>(width_) +
                     static_cast<std::size_t>(std::clamp(i, 0, width_ - 1))];
    };
    const RayLight& here = at(x, y);
    const RayLight* const around[4] = {&at(x - 1, y), &at(x + 1, y), &at(x, y - 1), &at(x, y + 1)};
    for (const RayLight* other : around) {
        if (differs(here.ambient, other->ambient, kAmbientStep)) return true;
        if (here.judged && other->judged && differs(here.rate, other->rate, kRateStep)) return true;
        if (here.rate > 0 && here.object != other->object) return true;
    }
    if (here.rate <= 0) return false;
    for (int axis = 0; axis < 2; ++axis) {
        const RayLight &before = *around[2 * axis], &after = *around[2 * axis + 1];
        if (&before == &here || &after == &here || !before.judged || !after.judged) continue;
        const double bend = before.position - 2 * here.position + after.position;
        if (std::abs(bend) * static_cast<double>(here.per_position) > kCrease) return true;
    }
    return false;
}

/// Light of a part of a pixel, `share` of its area, over which the sheet's place has the variance
/// footprint2 (in beam variances).
void ViewLight::emit(const RayLight& seen, const LightShape& shape, double share, double footprint2,
                     std::uint32_t pixel, const Moment& moment, LightBlock& block) const {
    StripeLight light;
    light.pixel = pixel;
    light.s0 = is_swept_ ? seen.position
                         : moment.s - seen.position * static_cast<double>(seen.per_position) /
                                          static_cast<double>(seen.per_s);
    if (moment.beam->parts().is_shaped()) {
        light.per_s = std::abs(seen.per_s);
        light.rate = seen.rate * static_cast<float>(share);
        moment.beam->parts().add(light, footprint2, shape, block.lights);
        return;
    }
    const double shrink = 1 / std::sqrt(1 + footprint2);
    light.per_s = std::abs(seen.per_s) * static_cast<float>(shrink);
    light.rate = seen.rate * static_cast<float>(share * shrink);
    block.lights.push_back(light);
}

void ViewLight::add_smooth(const Picture& picture, int x, int y, const Moment& moment,
                           LightBlock& block) const {
    const std::vector<RayLight>& image = picture.lights;
    const auto index = [&](int i, int j) {
        return static_cast<std::size_t>(j) * static_cast<std::size_t>(width_) +
               static_cast<std::size_t>(i);
    };
    const RayLight& here = image[index(x, y)];
    const auto pixel = static_cast<std::uint32_t>(index(x, y - block.row_begin));
    block.ambient[pixel] = here.ambient;
    if (here.rate <= 0) return;
    const LightShape shape = picture.shapes.empty() ? LightShape{} : picture.shapes[index(x, y)];

    // Slope and bend of the crossing along u and v, per pixel; the bend's mean over the pixel is
    // its 24th part.
    struct Course {
        double slope = 0, bend = 0;
    };
    const auto course = [&](std::size_t before, std::size_t after) {
        const RayLight &a = image[before], &b = image[after];
        if (!a.judged || !b.judged || before == after) return Course{};
        if (before == index(x, y) || after == index(x, y))
            return Course{b.position - a.position, 0};
        return Course{(b.position - a.position) / 2, a.position - 2 * here.position + b.position};
    };
    const Course u = course(index(std::max(x - 1, 0), y), index(std::min(x + 1, width_ - 1), y));
    const Course v = course(index(x, std::max(y - 1, 0)), index(x, std::min(y + 1, height_ - 1)));
    const double along_u = u.slope, along_v = v.slope;
    const double mean = here.position + (u.bend + v.bend) / 24;
    const double per = static_cast<double>(here.per_position);
    const auto parts = [&](double step) {
        return std::clamp(static_cast<int>(std::ceil(std::abs(step) * per / sampling_.part_sigmas)),
                          1, kMostParts);
    };
    const int parts_u = parts(along_u), parts_v = parts(along_v);
    const double part_u = along_u * per / parts_u, part_v = along_v * per / parts_v;
    // Speckle's slope over the pixel, from neighbours on the same lit surface.
    const auto grain = [&](std::size_t before, std::size_t after) {
        const RayLight &a = image[before], &b = image[after];
        if (a.rate <= 0 || b.rate <= 0 || a.object != b.object || before == after) return 0.0;
        const bool one_sided = before == index(x, y) || after == index(x, y);
        return static_cast<double>(b.speckle - a.speckle) / (one_sided ? 1 : 2);
    };
    const double grain_u =
        grain(index(std::max(x - 1, 0), y), index(std::min(x + 1, width_ - 1), y));
    const double grain_v =
        grain(index(x, std::max(y - 1, 0)), index(x, std::min(y + 1, height_ - 1)));
    const double footprint2 = (part_u * part_u + part_v * part_v) / 12;
    for (int j = 0; j < parts_v; ++j) {
        for (int i = 0; i < parts_u; ++i) {
            const double at_u = (i + 0.5) / parts_u - 0.5, at_v = (j + 0.5) / parts_v - 0.5;
            double position = mean + along_u * at_u + along_v * at_v;
            const double factor =
                static_cast<double>(here.speckle) + grain_u * at_u + grain_v * at_v;
            if (factor <= 0) continue;
            // Light leans to the brighter side of the part, by at most half of it.
            const double lean_u = grain_u / (12 * factor * parts_u * parts_u);
            const double lean_v = grain_v / (12 * factor * parts_v * parts_v);
            position += along_u * std::clamp(lean_u, -0.5 / parts_u, 0.5 / parts_u) +
                        along_v * std::clamp(lean_v, -0.5 / parts_v, 0.5 / parts_v);
            RayLight part = here;
            part.position = position;
            emit(part, shape, factor / (parts_u * parts_v), footprint2, pixel, moment, block);
        }
    }
}

/// Rays through one pixel, world frame.
struct ViewLight::PixelRays {
    Eigen::Vector3d middle, along_u, along_v;
    Eigen::Vector3d at(double u, double v) const { return middle + u * along_u + v * along_v; }
    Eigen::Vector3d at(const Eigen::Vector2d& place) const { return at(place.x(), place.y()); }
};

ViewLight::PixelRays ViewLight::rays_in(int x, int y, const HeadPose& head) const {
    // The lens bends rays so slowly that they are linear within a pixel (to 1e-6 px).
    const auto ray_of = [&](int i, int j) -> Eigen::Vector3d {
        return head.world_from_camera.rotation *
               rays_[static_cast<std::size_t>(std::clamp(j, 0, height_ - 1)) *
                         static_cast<std::size_t>(width_) +
                     static_cast<std::size_t>(std::clamp(i, 0, width_ - 1))];
    };
    return {ray_of(x, y), (ray_of(x + 1, y) - ray_of(x - 1, y)) / (x > 0 && x < width_ - 1 ? 2 : 1),
            (ray_of(x, y + 1) - ray_of(x, y - 1)) / (y > 0 && y < height_ - 1 ? 2 : 1)};
}

void ViewLight::add_uneven(const std::vector<RayLight>& image, int x, int y, const Moment& moment,
                           LightBlock& block) const {
    const auto at = [&](int i, int j) -> const RayLight& {
        return image[static_cast<std::size_t>(std::clamp(j, 0, height_ - 1)) *
                         static_cast<std::size_t>(width_) +
                     static_cast<std::size_t>(std::clamp(i, 0, width_ - 1))];
    };
    const double guess = at(x, y).judged ? at(x, y).position : 0;
    const PixelRays rays = rays_in(x, y, moment.head);
    std::vector<Eigen::Vector3d> directions;
    std::vector<SurfaceHit> hits;
    const PixelCaster cast = [&](std::span<const Eigen::Vector2d> places,
                                 std::span<PixelSample> samples) {
        directions.clear();
        for (const Eigen::Vector2d& place : places) directions.push_back(rays.at(place));
        hits.resize(places.size());
        geometry_.first_hits(moment.head.world_from_camera.translation, directions, hits);
        for (std::size_t i = 0; i < hits.size(); ++i)
            samples[i].light = judge(hits[i], moment, guess, samples[i].shape);
    };
    std::vector<PixelPart> parts;
    // A moving machine's frames are cast one by one, so there 16 rays must do.
    if (!is_swept_ || !optics_.sensor.cut_edges) {
        std::array<Eigen::Vector2d, kCountedRays> places;
        std::array<PixelSample, kCountedRays> samples;
        for (int i = 0; i < kCountedRays; ++i) places[static_cast<std::size_t>(i)] = stratum(i);
        cast(places, samples);
        for (const PixelSample& sample : samples) parts.push_back({sample, 1.0 / kCountedRays, 0});
    } else {
        cut_pixel(cast, sampling_, parts);
    }
    const auto pixel = static_cast<std::uint32_t>((y - block.row_begin) * width_ + x);
    double ambient = 0;
    for (const PixelPart& part : parts) {
        const RayLight& seen = part.sample.light;
        ambient += part.share * static_cast<double>(seen.ambient);
        if (seen.rate > 0)
            emit(seen, part.sample.shape, part.share * static_cast<double>(seen.speckle),
                 part.footprint2, pixel, moment, block);
    }
    block.ambient[pixel] = static_cast<float>(ambient);
}

std::vector<LightBlock> ViewLight::reflected_sweep(const Scene& scene) const {
    const SceneReflection& reflection = scene.reflection;
    if (!reflection.bounce && !reflection.mirrors) return {};
    const HeadPose head = head_pose(beams_[0].channel(), 0);
    const Eigen::Vector3d eye = head.world_from_camera.translation;
    std::optional<BounceLight> bounce;
    std::optional<MirrorLight> mirrors;
    if (reflection.bounce) bounce.emplace(scene, beams_[0], geometry_);
    if (reflection.mirrors) mirrors.emplace(scene, beams_[0], geometry_);
    std::vector<LightBlock> blocks(
        static_cast<std::size_t>((height_ + kBlockRows - 1) / kBlockRows));
    parallel_for_blocks(blocks.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t b = begin; b < end; ++b) {
            LightBlock& block = blocks[b];
            block.row_begin = static_cast<int>(b) * kBlockRows;
            block.row_end = std::min(height_, block.row_begin + kBlockRows);
            for (int y = block.row_begin; y < block.row_end; ++y)
                for (int x = 0; x < width_; ++x) {
                    const auto pixel =
                        static_cast<std::uint32_t>((y - block.row_begin) * width_ + x);
                    const Eigen::Vector3d middle =
                        head.world_from_camera.rotation *
                        rays_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
                              static_cast<std::size_t>(x)];
                    if (bounce)
                        bounce->add(geometry_.first_hit(eye, middle), eye, pixel, block.lights);
                    if (!mirrors) continue;
                    const PixelRays rays = rays_in(x, y, head);
                    std::array<Eigen::Vector3d, kCountedRays> directions;
                    std::array<SurfaceHit, kCountedRays> hits;
                    for (int i = 0; i < kCountedRays; ++i)
                        directions[static_cast<std::size_t>(i)] = rays.at(stratum(i));
                    geometry_.first_hits(eye, directions, hits);
                    for (const SurfaceHit& hit : hits)
                        mirrors->add(hit, eye, 1.0 / kCountedRays, pixel, block.lights);
                }
            sort_into_bins(block);
        }
    });
    return blocks;
}

std::vector<LightBlock> ViewLight::collect(Moment moment) const {
    std::vector<LightBlock> blocks(
        static_cast<std::size_t>((height_ + kBlockRows - 1) / kBlockRows));
    for (const Beam& beam : beams_) {
        moment.beam = &beam;
        collect_line(moment, blocks);
    }
    parallel_for_blocks(blocks.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t b = begin; b < end; ++b) sort_into_bins(blocks[b]);
    });
    return blocks;
}

void ViewLight::collect_line(const Moment& moment, std::vector<LightBlock>& blocks) const {
    const auto width = static_cast<std::size_t>(width_);
    Picture picture;
    picture.lights.resize(width * static_cast<std::size_t>(height_));
    if (moment.beam->parts().is_shaped()) picture.shapes.resize(picture.lights.size());
    const std::vector<RayLight>& image = picture.lights;
    parallel_for_blocks(static_cast<std::size_t>(height_), 8,
                        [&](std::size_t begin, std::size_t end) {
                            for (std::size_t row = begin; row < end; ++row)
                                first_rays(moment, static_cast<int>(row), picture);
                        });
    parallel_for_blocks(blocks.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t b = begin; b < end; ++b) {
            LightBlock& block = blocks[b];
            block.row_begin = static_cast<int>(b) * kBlockRows;
            block.row_end = std::min(height_, block.row_begin + kBlockRows);
            block.ambient.resize(width * static_cast<std::size_t>(block.row_end - block.row_begin));
            if (is_blurred_) block.spots.resize(block.ambient.size());
            for (int y = block.row_begin; y < block.row_end; ++y)
                for (int x = 0; x < width_; ++x) {
                    const std::size_t at =
                        static_cast<std::size_t>(y) * width + static_cast<std::size_t>(x);
                    const RayLight& here = image[at];
                    if (is_blurred_)
                        block.spots[at - static_cast<std::size_t>(block.row_begin) * width] =
                            here.spot;
                    if (is_uneven(image, x, y))
                        add_uneven(image, x, y, moment, block);
                    else
                        add_smooth(picture, x, y, moment, block);
                }
        }
    });
}

}  // namespace stria
