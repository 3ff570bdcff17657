#include "sim/scene_geometry.h"

#include <embree3/rtcore.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

#include "host/core/errors.h"

namespace stria {
namespace {

constexpr double kLiftMm = 2e-3;  ///< above the surface, where shadow rays start

struct ReleaseDevice {
    void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
};
struct ReleaseScene {
    void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
};
using DevicePtr = std::unique_ptr<std::remove_pointer_t<RTCDevice>, ReleaseDevice>;
using ScenePtr = std::unique_ptr<std::remove_pointer_t<RTCScene>, ReleaseScene>;

/// One object as rays see it, in its own frame.
struct Body {
    ScenePtr geometry;
    Rigid3 world_from_object, object_from_world;
    bool visible = true;
};

void check(RTCDevice device, const char* doing) {
    if (const RTCError error = rtcGetDeviceError(device); error != RTC_ERROR_NONE)
        throw Error(std::string("ray casting: ") + doing + " failed, Embree error " +
                    std::to_string(static_cast<int>(error)));
}

RTCGeometry triangles_geometry(RTCDevice device, const std::vector<Eigen::Vector3d>& positions,
                               const std::vector<std::array<std::uint32_t, 3>>& triangles) {
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* vertices = static_cast<float*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                3 * sizeof(float), positions.size()));
    auto* indices = static_cast<std::uint32_t*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                3 * sizeof(std::uint32_t), triangles.size()));
    check(device, "taking memory for a mesh");
    for (const Eigen::Vector3d& p : positions)
        for (int i = 0; i < 3; ++i) *vertices++ = static_cast<float>(p[i]);
    for (const auto& triangle : triangles)
        for (std::uint32_t vertex : triangle) *indices++ = vertex;
    return geometry;
}

RTCGeometry sphere_geometry(RTCDevice device, double radius_mm) {
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_SPHERE_POINT);
    auto* vertex = static_cast<float*>(rtcSetNewGeometryBuffer(
        geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT4, 4 * sizeof(float), 1));
    check(device, "taking memory for a sphere");
    vertex[0] = vertex[1] = vertex[2] = 0;
    vertex[3] = static_cast<float>(radius_mm);
    return geometry;
}

RTCGeometry object_geometry(RTCDevice device, const SceneObject& object) {
    switch (object.shape) {
        case SceneShape::sphere:
            return sphere_geometry(device, object.radius_mm);
        case SceneShape::mesh:
            return triangles_geometry(device, object.mesh->positions, object.mesh->triangles);
        case SceneShape::plane:
            break;
    }
    const Eigen::Vector2d a = object.corner_mm, b = object.corner_mm + object.size_mm;
    return triangles_geometry(
        device, {{a.x(), a.y(), 0}, {b.x(), a.y(), 0}, {b.x(), b.y(), 0}, {a.x(), b.y(), 0}},
        {{0, 1, 2}, {0, 2, 3}});
}

/// Distance along a ray (object frame, unit direction) to the primitive it is known to hit; what
/// Embree says where the exact answer is degenerate. Writes the primitive's normal.
double exact_distance(const SceneObject& object, unsigned primitive, const Eigen::Vector3d& origin,
                      const Eigen::Vector3d& ray, double embree_distance, Eigen::Vector3d& normal) {
    if (object.shape == SceneShape::sphere) {
        const double b = origin.dot(ray);
        const double radius2 = object.radius_mm * object.radius_mm;
        const double q = b * b - origin.squaredNorm() + radius2;
        const double root = std::sqrt(std::max(0.0, q));
        // From outside the near root, from inside the far one.
        const double distance = origin.squaredNorm() > radius2 ? -b - root : -b + root;
        normal = (origin + distance * ray).normalized();
        return distance;
    }
    Eigen::Vector3d on_plane = Eigen::Vector3d::Zero();
    normal = Eigen::Vector3d::UnitZ();
    if (object.shape == SceneShape::mesh) {
        const auto& triangle = object.mesh->triangles[primitive];
        on_plane = object.mesh->positions[triangle[0]];
        normal = (object.mesh->positions[triangle[1]] - on_plane)
                     .cross(object.mesh->positions[triangle[2]] - on_plane);
        const double length = normal.norm();
        normal = length > 0 ? Eigen::Vector3d(normal / length) : Eigen::Vector3d(-ray);
    }
    const double across = normal.dot(ray);
    if (std::abs(across) < 1e-6) return embree_distance;
    return normal.dot(on_plane - origin) / across;
}

/// Bilinear value (0..1) of a texture that repeats; position in texture lengths.
double texture_value(const GreyImage& image, double x, double y) {
    const double u = (x - std::floor(x)) * image.width - 0.5;
    const double v = (y - std::floor(y)) * image.height - 0.5;
    const double u0 = std::floor(u), v0 = std::floor(v);
    const auto wrap = [](double i, int n) { return (static_cast<int>(i) % n + n) % n; };
    const int x0 = wrap(u0, image.width), x1 = wrap(u0 + 1, image.width);
    const int y0 = wrap(v0, image.height), y1 = wrap(v0 + 1, image.height);
    const double fu = u - u0, fv = v - v0;
    const double top = (1 - fu) * image.at(x0, y0) + fu * image.at(x1, y0);
    const double bottom = (1 - fu) * image.at(x0, y1) + fu * image.at(x1, y1);
    return ((1 - fv) * top + fv * bottom) / 255.0;
}

/// Mean of a vertex attribute at a point of a triangle, by its areas.
double attribute_value(const TriMesh& mesh, const VertexAttribute& attribute, unsigned primitive,
                       const Eigen::Vector3d& p) {
    const auto& t = mesh.triangles[primitive];
    const Eigen::Vector3d a = mesh.positions[t[0]], b = mesh.positions[t[1]],
                          c = mesh.positions[t[2]];
    const double wa = (b - p).cross(c - p).norm(), wb = (c - p).cross(a - p).norm(),
                 wc = (a - p).cross(b - p).norm();
    const double sum = wa + wb + wc;
    if (!(sum > 0)) return attribute.values[t[0]];
    return (wa * attribute.values[t[0]] + wb * attribute.values[t[1]] +
            wc * attribute.values[t[2]]) /
           sum;
}

RTCRayHit single_ray(const Eigen::Vector3d& origin, const Eigen::Vector3d& unit, double near,
                     double far) {
    RTCRayHit query{};
    query.ray.org_x = static_cast<float>(origin.x());
    query.ray.org_y = static_cast<float>(origin.y());
    query.ray.org_z = static_cast<float>(origin.z());
    query.ray.dir_x = static_cast<float>(unit.x());
    query.ray.dir_y = static_cast<float>(unit.y());
    query.ray.dir_z = static_cast<float>(unit.z());
    query.ray.tnear = static_cast<float>(near);
    query.ray.tfar = static_cast<float>(far);
    query.ray.mask = ~0u;
    query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    return query;
}

RTCIntersectContext make_context(bool coherent) {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags =
        coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
    return context;
}

}  // namespace

struct SceneGeometry::Content {
    std::vector<SceneObject> objects;
    std::vector<const VertexAttribute*> albedo_attributes;
    std::vector<SceneView> views;
    DevicePtr device;
    std::vector<Body> bodies;
    ScenePtr world;

    /// The point and its surface, computed in double on the primitive that Embree found.
    SurfaceHit finish(unsigned object_index, unsigned primitive, const Eigen::Vector3d& origin,
                      const Eigen::Vector3d& unit, double embree_distance) const {
        const SceneObject& object = objects[object_index];
        const Body& body = bodies[object_index];
        const Eigen::Vector3d o = body.object_from_world * origin;
        const Eigen::Vector3d ray = body.object_from_world.rotation * unit;
        Eigen::Vector3d normal;
        const double distance = exact_distance(object, primitive, o, ray, embree_distance, normal);
        if (normal.dot(ray) > 0) normal = -normal;

        SurfaceHit hit;
        hit.object = static_cast<int>(object_index);
        hit.point = origin + distance * unit;
        hit.normal = (body.world_from_object.rotation * normal).cast<float>();
        hit.roughness_rad = static_cast<float>(object.roughness_rad);
        hit.specular = static_cast<float>(object.specular);
        hit.gloss = static_cast<float>(object.gloss);
        hit.albedo = static_cast<float>(albedo_at(object_index, primitive, o + distance * ray));
        return hit;
    }

    double albedo_at(unsigned object_index, unsigned primitive, const Eigen::Vector3d& p) const {
        const SceneObject& object = objects[object_index];
        if (object.mirror) return 0;
        double albedo = object.albedo;
        if (object.texture_image)
            albedo *= texture_value(*object.texture_image,
                                    (p.x() - object.corner_mm.x()) / object.texture_size_mm.x(),
                                    (p.y() - object.corner_mm.y()) / object.texture_size_mm.y());
        if (const VertexAttribute* attribute = albedo_attributes[object_index])
            albedo *= attribute_value(*object.mesh, *attribute, primitive, p);
        return albedo;
    }

    SurfaceHit cast(const Eigen::Vector3d& origin, const Eigen::Vector3d& unit, double near,
                    double far) const {
        RTCIntersectContext context = make_context(false);
        RTCRayHit query = single_ray(origin, unit, near, far);
        rtcIntersect1(world.get(), &context, &query);
        if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return {};
        return finish(query.hit.instID[0], query.hit.primID, origin, unit, query.ray.tfar);
    }
};

SceneGeometry::SceneGeometry(const Scene& scene) : content_(std::make_unique<Content>()) {
    content_->objects = scene.objects;
    content_->views = scene.views;
    content_->device.reset(rtcNewDevice(nullptr));
    if (!content_->device) throw Error("ray casting: Embree found no device");
    RTCDevice device = content_->device.get();
    for (const SceneObject& object : content_->objects) {
        Body body;
        body.geometry.reset(rtcNewScene(device));
        rtcSetSceneFlags(body.geometry.get(), RTC_SCENE_FLAG_ROBUST);
        RTCGeometry geometry = object_geometry(device, object);
        rtcCommitGeometry(geometry);
        rtcAttachGeometry(body.geometry.get(), geometry);
        rtcReleaseGeometry(geometry);
        rtcCommitScene(body.geometry.get());
        check(device, "building the search tree");
        content_->bodies.push_back(std::move(body));
        const VertexAttribute* albedo =
            object.mesh ? object.mesh->find_attribute("albedo") : nullptr;
        const bool fits = albedo && albedo->components == 1 &&
                          albedo->values.size() == object.mesh->positions.size();
        content_->albedo_attributes.push_back(fits ? albedo : nullptr);
    }
    set_view(0);
}

SceneGeometry::~SceneGeometry() = default;
SceneGeometry::SceneGeometry(SceneGeometry&&) noexcept = default;
SceneGeometry& SceneGeometry::operator=(SceneGeometry&&) noexcept = default;

void SceneGeometry::set_view(int view) {
    Content& c = *content_;
    const int count = std::max(1, static_cast<int>(c.views.size()));
    if (view < 0 || view >= count)
        throw std::invalid_argument("view = " + std::to_string(view) + ": expected 0 to " +
                                    std::to_string(count - 1));
    for (std::size_t i = 0; i < c.objects.size(); ++i) {
        Body& body = c.bodies[i];
        body.visible = true;
        body.world_from_object = c.objects[i].world_from_object;
        if (!c.views.empty()) {
            const SceneView& placed = c.views[static_cast<std::size_t>(view)];
            for (const ViewPose& pose : placed.poses)
                if (pose.object == c.objects[i].name)
                    body.world_from_object = pose.world_from_object;
            for (const std::string& hidden : placed.hidden)
                if (hidden == c.objects[i].name) body.visible = false;
        }
        body.object_from_world = body.world_from_object.inverse();
    }

    c.world.reset(rtcNewScene(c.device.get()));
    rtcSetSceneFlags(c.world.get(), RTC_SCENE_FLAG_ROBUST);
    for (std::size_t i = 0; i < c.bodies.size(); ++i) {
        if (!c.bodies[i].visible) continue;
        RTCGeometry instance = rtcNewGeometry(c.device.get(), RTC_GEOMETRY_TYPE_INSTANCE);
        rtcSetGeometryInstancedScene(instance, c.bodies[i].geometry.get());
        Eigen::Matrix<float, 3, 4> transform;  // column-major, as Embree wants it
        transform.leftCols<3>() = c.bodies[i].world_from_object.rotation.cast<float>();
        transform.col(3) = c.bodies[i].world_from_object.translation.cast<float>();
        rtcSetGeometryTransform(instance, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, transform.data());
        rtcCommitGeometry(instance);
        rtcAttachGeometryByID(c.world.get(), instance, static_cast<unsigned>(i));
        rtcReleaseGeometry(instance);
    }
    rtcCommitScene(c.world.get());
    check(c.device.get(), "placing the objects");
}

SurfaceHit SceneGeometry::first_hit(const Eigen::Vector3d& origin,
                                    const Eigen::Vector3d& direction) const {
    return content_->cast(origin, direction.normalized(), 0,
                          std::numeric_limits<float>::infinity());
}

void SceneGeometry::first_hits(const Eigen::Vector3d& origin,
                               std::span<const Eigen::Vector3d> directions,
                               std::span<SurfaceHit> hits) const {
    constexpr std::size_t kLanes = 16;
    RTCIntersectContext context = make_context(true);
    for (std::size_t begin = 0; begin < directions.size(); begin += kLanes) {
        const std::size_t lanes = std::min(kLanes, directions.size() - begin);
        alignas(64) int valid[kLanes];
        RTCRayHit16 query;
        Eigen::Vector3d unit[kLanes];
        for (std::size_t i = 0; i < kLanes; ++i) {
            valid[i] = i < lanes ? -1 : 0;
            unit[i] = directions[begin + std::min(i, lanes - 1)].normalized();
            query.ray.org_x[i] = static_cast<float>(origin.x());
            query.ray.org_y[i] = static_cast<float>(origin.y());
            query.ray.org_z[i] = static_cast<float>(origin.z());
            query.ray.dir_x[i] = static_cast<float>(unit[i].x());
            query.ray.dir_y[i] = static_cast<float>(unit[i].y());
            query.ray.dir_z[i] = static_cast<float>(unit[i].z());
            query.ray.tnear[i] = 0;
            query.ray.tfar[i] = std::numeric_limits<float>::infinity();
            query.ray.time[i] = 0;
            query.ray.mask[i] = ~0u;
            query.ray.id[i] = 0;
            query.ray.flags[i] = 0;
            query.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
            query.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
        }
        rtcIntersect16(valid, content_->world.get(), &context, &query);
        for (std::size_t i = 0; i < lanes; ++i)
            hits[begin + i] =
                query.hit.geomID[i] == RTC_INVALID_GEOMETRY_ID
                    ? SurfaceHit{}
                    : content_->finish(query.hit.instID[0][i], query.hit.primID[i], origin, unit[i],
                                       static_cast<double>(query.ray.tfar[i]));
    }
}

bool SceneGeometry::is_occluded(const SurfaceHit& from, const Eigen::Vector3d& to) const {
    const Eigen::Vector3d normal = from.normal.cast<double>();
    if (normal.dot(to - from.point) <= 0) return true;
    const Eigen::Vector3d start = from.point + kLiftMm * normal;
    const double distance = (to - start).norm();
    RTCIntersectContext context = make_context(false);
    RTCRay ray = single_ray(start, (to - start) / distance, 0, distance).ray;
    rtcOccluded1(content_->world.get(), &context, &ray);
    return ray.tfar < 0;
}

Rigid3 SceneGeometry::world_from_object(int object) const {
    return content_->bodies.at(static_cast<std::size_t>(object)).world_from_object;
}

bool SceneGeometry::is_visible(int object) const {
    return content_->bodies.at(static_cast<std::size_t>(object)).visible;
}

Eigen::Vector3d SceneGeometry::point_in_object(const SurfaceHit& hit) const {
    return content_->bodies.at(static_cast<std::size_t>(hit.object)).object_from_world * hit.point;
}

std::optional<double> SceneGeometry::error_along(const Eigen::Vector3d& point_in_world,
                                                 const Eigen::Vector3d& direction,
                                                 double reach_mm) const {
    const Eigen::Vector3d unit = direction.normalized();
    const Eigen::Vector3d start = point_in_world - reach_mm * unit;
    std::optional<double> nearest;
    double from = 0;
    for (int i = 0; i < 64 && from < 2 * reach_mm; ++i) {
        const SurfaceHit hit = content_->cast(start, unit, from, 2 * reach_mm);
        if (hit.object < 0) break;
        const double error = unit.dot(point_in_world - hit.point);
        if (std::abs(error) <= reach_mm && (!nearest || std::abs(error) < std::abs(*nearest)))
            nearest = error;
        from = std::max(from, unit.dot(hit.point - start)) + 1e-3;
    }
    return nearest;
}

}  // namespace stria
