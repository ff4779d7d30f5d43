// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/simulation/ray_caster.hpp"

#include <algorithm>
#include <cmath>
#include <type_traits>

#include <embree3/rtcore.h>
#include <tbb/task_arena.h>

namespace lidar_mapping::simulation {

namespace {

template <auto release>
struct Release {
  template <typename T>
  void operator()(T* handle) const {
    release(handle);
  }
};
template <typename T, auto release>
using Handle = std::unique_ptr<std::remove_pointer_t<T>, Release<release>>;
using Device = Handle<RTCDevice, rtcReleaseDevice>;
using Scene = Handle<RTCScene, rtcReleaseScene>;
using Geometry = Handle<RTCGeometry, rtcReleaseGeometry>;

constexpr int kPacket = 8;  ///< rays of an RTCRayHit8 of Embree, for registers of 256 bits
/// Embree decides with other roundings in wider registers, and a drive must not depend on the
/// processor that simulates it.
constexpr const char* kDeviceOptions = "max_isa=avx2";

Geometry make_triangles(RTCDevice device, const TriangleMesh& mesh) {
  Geometry geometry(rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE));
  auto* vertices = static_cast<float*>(
      rtcSetNewGeometryBuffer(geometry.get(), RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                              3 * sizeof(float), mesh.vertices.size()));
  for (const Eigen::Vector3f& vertex : mesh.vertices) {
    vertices = std::copy_n(vertex.data(), 3, vertices);
  }
  auto* indices = static_cast<unsigned*>(
      rtcSetNewGeometryBuffer(geometry.get(), RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                              3 * sizeof(unsigned), mesh.triangles.size()));
  for (const auto& triangle : mesh.triangles) {
    indices = std::copy(triangle.begin(), triangle.end(), indices);
  }
  rtcCommitGeometry(geometry.get());
  return geometry;
}

/// Builds the tree of a scene in the thread of the caller alone. So the tree, and with it the
/// choice among equal hits, does not depend on other threads. (The limit of threads of the device
/// would apply to all of TBB.)
void commit(RTCScene scene) {
  tbb::task_arena alone(1);
  alone.execute([scene] { rtcCommitScene(scene); });
}

Scene make_mesh_scene(RTCDevice device, const TriangleMesh& mesh) {
  Scene scene(rtcNewScene(device));
  rtcSetSceneFlags(scene.get(), RTC_SCENE_FLAG_ROBUST);
  rtcAttachGeometry(scene.get(), make_triangles(device, mesh).get());
  commit(scene.get());
  return scene;
}

Eigen::Matrix<float, 3, 4> to_rows(const Pose& pose) {
  return pose.matrix().topRows<3>().cast<float>();
}

/// Adds an instance of `part` with its poses at the beginning and the end of the frame.
void add_instance(RTCDevice device, RTCScene scene, RTCScene part, unsigned id, const Pose& first,
                  const Pose& last) {
  Geometry instance(rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE));
  rtcSetGeometryInstancedScene(instance.get(), part);
  rtcSetGeometryTimeStepCount(instance.get(), 2);
  const Eigen::Matrix<float, 3, 4> begin = to_rows(first), end = to_rows(last);
  rtcSetGeometryTransform(instance.get(), 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, begin.data());
  rtcSetGeometryTransform(instance.get(), 1, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, end.data());
  rtcCommitGeometry(instance.get());
  rtcAttachGeometryByID(scene, instance.get(), id);
}

void fill(RTCRayHit8& packet, int lane, const Ray& ray, float min_range, float max_range) {
  packet.ray.org_x[lane] = ray.origin.x();
  packet.ray.org_y[lane] = ray.origin.y();
  packet.ray.org_z[lane] = ray.origin.z();
  packet.ray.dir_x[lane] = ray.direction.x();
  packet.ray.dir_y[lane] = ray.direction.y();
  packet.ray.dir_z[lane] = ray.direction.z();
  packet.ray.tnear[lane] = min_range;
  packet.ray.tfar[lane] = max_range;
  packet.ray.time[lane] = ray.time;
  packet.ray.mask[lane] = ~0U;
  packet.ray.flags[lane] = 0;
  packet.hit.geomID[lane] = RTC_INVALID_GEOMETRY_ID;
  packet.hit.instID[0][lane] = RTC_INVALID_GEOMETRY_ID;
}

using Transform = Eigen::Matrix<double, 3, 4>;

/// Where a mover is while a frame is taken. Embree blends the two linearly as well.
struct Motion {
  Transform begin = Transform::Zero(), end = Transform::Zero();

  Transform at(double fraction) const { return (1.0 - fraction) * begin + fraction * end; }
};

/// The movers during one frame.
struct Frame {
  Scene movers;                 ///< Instance i is mover i; none if nothing moves.
  std::vector<Motion> motions;  ///< One per mover.
};

using Triangle = std::array<Eigen::Vector3d, 3>;

Triangle triangle_of(const TriangleMesh& mesh, unsigned index) {
  Triangle corners;
  for (std::size_t i = 0; i < 3; ++i)
    corners[i] = mesh.vertices[mesh.triangles[index][i]].cast<double>();
  return corners;
}

Eigen::Vector3d normal_of(const Triangle& triangle) {
  return (triangle[1] - triangle[0]).cross(triangle[2] - triangle[0]).normalized();
}

/// Range and incidence of a ray that Embree says meets the plane with this point and this normal.
/// Embree's own range comes from the processor's approximate reciprocal, which makers of processors
/// round each in their own way; it remains where the ray lies in the plane.
void measure(const Ray& ray, const Eigen::Vector3d& point, const Eigen::Vector3d& normal,
             Hit& hit) {
  const double closing = normal.dot(ray.direction.cast<double>());
  hit.cosine = static_cast<float>(std::abs(closing));
  if (closing == 0.0) return;
  hit.range = static_cast<float>(normal.dot(point - ray.origin.cast<double>()) / closing);
}

}  // namespace

class RayCaster::Impl {
 public:
  explicit Impl(const World& world) : world_(world), device_(rtcNewDevice(kDeviceOptions)) {
    fixed_ = make_mesh_scene(device_.get(), world.fixed);
    fixed_normals_.reserve(world.fixed.triangles.size());
    for (unsigned i = 0; i < world.fixed.triangles.size(); ++i) {
      fixed_normals_.push_back(normal_of(triangle_of(world.fixed, i)));
    }
    for (const TriangleMesh& shape : world.shapes) {
      shapes_.push_back(make_mesh_scene(device_.get(), shape));
    }
  }

  Frame frame(double begin_s, double end_s) const {
    Frame frame{nullptr, std::vector<Motion>(world_.movers.size())};
    for (std::size_t i = 0; i < world_.movers.size(); ++i) {
      const Mover& mover = world_.movers[i];
      const auto first = mover.pose(begin_s), last = mover.pose(end_s);
      if (!first || !last) continue;
      if (!frame.movers) {
        frame.movers.reset(rtcNewScene(device_.get()));
        rtcSetSceneFlags(frame.movers.get(), RTC_SCENE_FLAG_ROBUST);
      }
      add_instance(device_.get(), frame.movers.get(), shapes_[mover.shape].get(),
                   static_cast<unsigned>(i), *first, *last);
      frame.motions[i] = {first->matrix().topRows<3>(), last->matrix().topRows<3>()};
    }
    if (frame.movers) commit(frame.movers.get());
    return frame;
  }

  /// The fixed world by itself, as its rays need no transform; then what moves in front of it.
  void intersect(const Frame& frame, const int* valid, RTCIntersectContext& context,
                 RTCRayHit8& packet) const {
    rtcIntersect8(valid, fixed_.get(), &context, &packet);
    if (frame.movers) rtcIntersect8(valid, frame.movers.get(), &context, &packet);
  }

  Hit hit(const Frame& frame, const Ray& ray, const RTCRayHit8& packet, int lane) const {
    Hit hit;
    if (packet.hit.geomID[lane] == RTC_INVALID_GEOMETRY_ID) return hit;
    hit.range = packet.ray.tfar[lane];
    const unsigned mover = packet.hit.instID[0][lane], index = packet.hit.primID[lane];
    hit.moving = mover != RTC_INVALID_GEOMETRY_ID;
    if (!hit.moving) {
      const TriangleMesh& mesh = world_.fixed;
      hit.reflectivity = mesh.reflectivity[index];
      measure(ray, mesh.vertices[mesh.triangles[index][0]].cast<double>(), fixed_normals_[index],
              hit);
      return hit;
    }
    const TriangleMesh& mesh = world_.shapes[world_.movers[mover].shape];
    hit.reflectivity = mesh.reflectivity[index];
    const Transform T_map_shape = frame.motions[mover].at(ray.time);
    Triangle triangle = triangle_of(mesh, index);
    for (Eigen::Vector3d& corner : triangle) corner = T_map_shape * corner.homogeneous();
    measure(ray, triangle[0], normal_of(triangle), hit);
    return hit;
  }

 private:
  const World& world_;
  Device device_;
  Scene fixed_;
  std::vector<Eigen::Vector3d> fixed_normals_;  ///< Unit normal of each triangle of `fixed_`.
  std::vector<Scene> shapes_;
};

RayCaster::RayCaster(const World& world) : impl_(std::make_unique<Impl>(world)) {}
RayCaster::~RayCaster() = default;

void RayCaster::cast(const std::vector<Ray>& rays, double begin_s, double end_s, float min_range,
                     float max_range, std::vector<Hit>& hits) const {
  hits.resize(rays.size());
  const Frame frame = impl_->frame(begin_s, end_s);
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  alignas(32) RTCRayHit8 packet;
  alignas(32) int valid[kPacket];
  for (std::size_t first = 0; first < rays.size(); first += kPacket) {
    const int count = static_cast<int>(std::min<std::size_t>(kPacket, rays.size() - first));
    for (int lane = 0; lane < kPacket; ++lane) {
      valid[lane] = lane < count ? -1 : 0;
      if (lane < count) fill(packet, lane, rays[first + lane], min_range, max_range);
    }
    impl_->intersect(frame, valid, context, packet);
    for (int lane = 0; lane < count; ++lane) {
      hits[first + lane] = impl_->hit(frame, rays[first + lane], packet, lane);
    }
  }
}

}  // namespace lidar_mapping::simulation
