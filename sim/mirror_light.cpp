#include "sim/mirror_light.h"

#include <cmath>

namespace stria {
namespace {

constexpr double kLiftMm = 5e-3;  ///< off the mirror, where shadow rays end

}  // namespace

MirrorLight::MirrorLight(const Scene& scene, const Beam& beam, const SceneGeometry& geometry)
    : beam_(beam), geometry_(geometry), middle_s_((scene.axis.min + scene.axis.max) / 2) {
    for (std::size_t i = 0; i < scene.objects.size(); ++i) {
        const SceneObject& object = scene.objects[i];
        if (!object.mirror || !geometry.is_visible(static_cast<int>(i))) continue;
        const Rigid3 pose = geometry.world_from_object(static_cast<int>(i));
        mirrors_.push_back({pose.inverse(), pose.rotation.col(2), pose.translation,
                            object.corner_mm, object.corner_mm + object.size_mm, object.albedo});
    }
}

void MirrorLight::add(const SurfaceHit& hit, const Eigen::Vector3d& eye_in_world, double share,
                      std::uint32_t pixel, std::vector<StripeLight>& lights) const {
    if (hit.object < 0 || hit.albedo + hit.specular <= 0) return;
    for (const Mirror& mirror : mirrors_) {
        const double height = mirror.normal.dot(hit.point - mirror.point);
        const auto image_of = [&](const Eigen::Vector3d& p) -> Eigen::Vector3d {
            return p - 2 * mirror.normal.dot(p - mirror.point) * mirror.normal;
        };
        // The surface's mirror image under the laser is the surface under the laser's mirror image.
        SurfaceHit image = hit;
        image.point = image_of(hit.point);
        const Eigen::Vector3d normal = hit.normal.cast<double>();
        image.normal = (normal - 2 * mirror.normal.dot(normal) * mirror.normal).cast<float>();
        const auto beam = beam_.passing(image, middle_s_, image_of(eye_in_world));
        if (!beam || beam->rate <= 0) continue;
        const double light_height = mirror.normal.dot(beam->light_in_world - mirror.point);
        if (height * light_height <= 0) continue;  // behind the mirror
        const Eigen::Vector3d at =
            image.point + height / (height + light_height) * (beam->light_in_world - image.point);
        const Eigen::Vector2d in_plane = (mirror.object_from_world * at).head<2>();
        if ((in_plane.array() < mirror.low.array()).any() ||
            (in_plane.array() > mirror.high.array()).any())
            continue;
        SurfaceHit on_mirror;
        on_mirror.point = at;
        on_mirror.normal = (height > 0 ? mirror.normal : -mirror.normal).cast<float>();
        const Eigen::Vector3d above = at + kLiftMm * on_mirror.normal.cast<double>();
        if (geometry_.is_occluded(hit, above) ||
            geometry_.is_occluded(on_mirror, beam->light_in_world))
            continue;
        lights.push_back({beam->position, static_cast<float>(beam->per_s),
                          static_cast<float>(share * mirror.share * beam->rate), pixel});
    }
}

}  // namespace stria
