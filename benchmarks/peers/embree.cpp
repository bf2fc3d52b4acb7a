// Embree 3: depth images with packets of 8 and 16 rays; the faster of them, without the time to build the tree.
//
//   g++ -O3 -march=native -DNDEBUG embree.cpp -o embree -lembree3
//   ./embree WORKLOAD
#include <embree3/rtcore.h>

#include <cmath>
#include <cstring>

#include "common.hpp"

namespace {

constexpr int width = 640, height = 480;

RTCScene scene_of(RTCDevice device, const std::string& path) {
  const std::vector<int32_t> words = read_all<int32_t>(path);
  const size_t n_vertices = static_cast<size_t>(words[0]), n_triangles = static_cast<size_t>(words[1]);
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  void* vertices =
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), n_vertices);
  std::memcpy(vertices, &words[2], 12 * n_vertices);
  void* triangles =
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(uint32_t), n_triangles);
  std::memcpy(triangles, &words[2 + 3 * n_vertices], 12 * n_triangles);
  rtcCommitGeometry(geometry);
  RTCScene scene = rtcNewScene(device);
  rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_HIGH);
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(scene);
  return scene;
}

struct Camera {
  float rotation[9], origin[3];
  explicit Camera(const double* m) {
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column)
        rotation[3 * row + column] = static_cast<float>(m[4 * row + column]);
      origin[row] = static_cast<float>(m[4 * row + 3]);
    }
  }
};

template <class Packet>
void set_ray(Packet& packet, int lane, const Camera& camera, int u, int v) {
  const float x = (static_cast<float>(u) - 320.f) / 610.f, y = (static_cast<float>(v) - 240.f) / 610.f;
  const float* r = camera.rotation;
  packet.ray.org_x[lane] = camera.origin[0];
  packet.ray.org_y[lane] = camera.origin[1];
  packet.ray.org_z[lane] = camera.origin[2];
  packet.ray.dir_x[lane] = r[0] * x + r[1] * y + r[2];
  packet.ray.dir_y[lane] = r[3] * x + r[4] * y + r[5];
  packet.ray.dir_z[lane] = r[6] * x + r[7] * y + r[8];
  packet.ray.tnear[lane] = 0;
  packet.ray.tfar[lane] = INFINITY;
  packet.ray.mask[lane] = ~0u;
  packet.ray.flags[lane] = 0;
  packet.ray.time[lane] = 0;
  packet.hit.geomID[lane] = RTC_INVALID_GEOMETRY_ID;
  packet.hit.instID[0][lane] = RTC_INVALID_GEOMETRY_ID;
}

void intersect(const int* valid, RTCScene scene, RTCIntersectContext* context, RTCRayHit8* packet) {
  rtcIntersect8(valid, scene, context, packet);
}

void intersect(const int* valid, RTCScene scene, RTCIntersectContext* context, RTCRayHit16* packet) {
  rtcIntersect16(valid, scene, context, packet);
}

// Renders an image in packets of 4 x `rows` pixels; depth is the ray's parameter, since directions have z = 1.
template <class Packet, int rows>
size_t render(RTCScene scene, const Camera& camera, std::vector<float>& depth) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  alignas(64) int valid[16];
  std::fill(valid, valid + 16, -1);
  size_t n_hits = 0;
  for (int v = 0; v < height; v += rows)
    for (int u = 0; u < width; u += 4) {
      alignas(64) Packet packet;
      for (int lane = 0; lane < 4 * rows; ++lane) set_ray(packet, lane, camera, u + lane % 4, v + lane / 4);
      intersect(valid, scene, &context, &packet);
      for (int lane = 0; lane < 4 * rows; ++lane) {
        const bool is_hit = packet.hit.geomID[lane] != RTC_INVALID_GEOMETRY_ID;
        depth[static_cast<size_t>((v + lane / 4) * width + u + lane % 4)] = packet.ray.tfar[lane];
        n_hits += is_hit;
      }
    }
  return n_hits;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: embree WORKLOAD\n");
    return 2;
  }
  const std::string folder = argv[1];
  RTCDevice device = rtcNewDevice("threads=1");
  const Poses poses{read_all<double>(folder + "/poses.f64")};
  const char* names[] = {"1x", "4x", "16x"};
  std::vector<float> depth(width * height);
  for (int mesh = 0; mesh < 3; ++mesh) {
    RTCScene scene = scene_of(device, folder + "/mesh" + std::to_string(mesh) + ".bin");
    size_t n_hits = 0;
    const auto all_images = [&](auto&& one) {
      n_hits = 0;
      for (size_t i = 0; i < poses.size(); ++i) n_hits += one(Camera(poses[i]));
    };
    const double by_8 = least_ms(
        [&] { all_images([&](const Camera& camera) { return render<RTCRayHit8, 2>(scene, camera, depth); }); });
    const double by_16 = least_ms(
        [&] { all_images([&](const Camera& camera) { return render<RTCRayHit16, 4>(scene, camera, depth); }); });
    std::fprintf(stderr, "embree: %zu hits\n", n_hits);
    report("embree", "depth image", names[mesh], std::min(by_8, by_16) / n_images);
    rtcReleaseScene(scene);
  }
  rtcReleaseDevice(device);
}
