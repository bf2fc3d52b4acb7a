// Bonxai: inserting clouds, with its own way to walk along rays (exact since July 2026, Bresenham lines before).
//
//   g++ -std=c++17 -O3 -march=native -DNDEBUG -I BONXAI/include -I /usr/include/eigen3
//       bonxai.cpp BONXAI/src/probabilistic_map.cpp -o bonxai
//   ./bonxai WORKLOAD
//
// BONXAI/include holds the header folders bonxai/ and bonxai_map/ of a checkout, which has them apart.
#include <limits>

#include "bonxai_map/probabilistic_map.hpp"
#include "common.hpp"

namespace {

using Map = Bonxai::ProbabilisticMap;

const VoxelSize sizes[] = {{0.01, "1 cm"}, {0.005, "5 mm"}, {0.002, "2 mm"}, {0.001, "1 mm"}};

struct Scan {
  std::vector<Eigen::Vector3f> points;
  Eigen::Vector3f origin;
};

std::vector<Scan> read_scans(const std::string& folder, char set) {
  std::vector<Scan> scans;
  for (const Cloud& cloud : read_clouds(folder, set)) {
    Scan scan;
    scan.origin = Eigen::Map<const Eigen::Vector3d>(cloud.origin).cast<float>();
    for (size_t i = 0; i < cloud.size(); ++i) scan.points.emplace_back(&cloud.xyz[3 * i]);
    scans.push_back(std::move(scan));
  }
  return scans;
}

Map::Options octomaps_model(Map::Options options) {
  options.prob_hit_log = Map::logods(0.7f);
  options.prob_miss_log = Map::logods(0.4f);
  options.clamp_min_log = Map::logods(0.1192f);
  options.clamp_max_log = Map::logods(0.971f);
  return options;
}

void time_insertion(const std::vector<Scan>& scans, const char* stage, size_t n_sizes) {
  for (size_t i = 0; i < n_sizes; ++i) {
    const double ms = least_ms([&] {
      Map map(sizes[i].metres);
      map.setOptions(octomaps_model(map.options()));
      for (const Scan& scan : scans)
        map.insertPointCloud(scan.points, scan.origin, std::numeric_limits<double>::infinity());
    });
    report("bonxai", stage, sizes[i].name, ms / n_images);
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: bonxai WORKLOAD\n");
    return 2;
  }
  time_insertion(read_scans(argv[1], 'A'), "insertion A; per end voxel", 4);
  time_insertion(read_scans(argv[1], 'B'), "insertion B; per end voxel", 2);
}
