// OctoMap: inserting clouds, casting planning rays, reading and writing files.
//
//   g++ -O3 -march=native -DNDEBUG octomap.cpp -o octomap -loctomap -loctomath
//   ./octomap WORKLOAD
#include <octomap/octomap.h>

#include <iostream>
#include <sstream>

#include "common.hpp"

namespace {

const VoxelSize sizes[] = {{0.01, "1 cm"}, {0.005, "5 mm"}, {0.002, "2 mm"}, {0.001, "1 mm"}};

octomap::OcTree empty_tree(double voxel_size) {
  octomap::OcTree tree(voxel_size);
  tree.setProbHit(0.7);
  tree.setProbMiss(0.4);
  tree.setClampingThresMin(0.1192);
  tree.setClampingThresMax(0.971);
  return tree;
}

struct Scan {
  octomap::Pointcloud points;
  octomap::point3d origin;
};

std::vector<Scan> read_scans(const std::string& folder, char set) {
  std::vector<Scan> scans;
  for (const Cloud& cloud : read_clouds(folder, set)) {
    Scan scan;
    scan.origin = octomap::point3d(static_cast<float>(cloud.origin[0]), static_cast<float>(cloud.origin[1]),
                                   static_cast<float>(cloud.origin[2]));
    for (size_t i = 0; i < cloud.size(); ++i)
      scan.points.push_back(cloud.xyz[3 * i], cloud.xyz[3 * i + 1], cloud.xyz[3 * i + 2]);
    scans.push_back(std::move(scan));
  }
  return scans;
}

void insert(octomap::OcTree& tree, const std::vector<Scan>& scans, bool one_ray_per_end_voxel) {
  for (const Scan& scan : scans) tree.insertPointCloud(scan.points, scan.origin, -1, false, one_ray_per_end_voxel);
}

void time_insertion(const std::vector<Scan>& scans, const char* stage, bool per_end_voxel, size_t n_sizes) {
  for (size_t i = 0; i < n_sizes; ++i) {
    // Seconds per image at the finest sizes: one run says enough.
    const int min_runs = sizes[i].metres < 0.003 ? 1 : 2;
    const double ms = least_ms(
        [&] {
          octomap::OcTree tree = empty_tree(sizes[i].metres);
          insert(tree, scans, per_end_voxel);
        },
        min_runs);
    report("octomap", stage, sizes[i].name, ms / n_images);
  }
}

// Rays of every 50th of the 5000 views, 32 x 24 over the image, as far as a metre; the time is stated for all views.
void time_rays(const std::string& folder, const std::vector<Scan>& scans) {
  const size_t stride = 50;
  const Poses views{read_all<double>(folder + "/views5000.f64")};
  for (size_t s = 0; s < 3; ++s) {
    octomap::OcTree tree = empty_tree(sizes[s].metres);
    insert(tree, scans, true);
    const double ms = least_ms([&] {
      for (size_t view = 0; view < views.size(); view += stride) {
        const double* m = views[view];
        const octomap::point3d origin(static_cast<float>(m[3]), static_cast<float>(m[7]), static_cast<float>(m[11]));
        for (int row = 0; row < 24; ++row)
          for (int column = 0; column < 32; ++column) {
            const double x = ((column + 0.5) * 20 - 320) / 610, y = ((row + 0.5) * 20 - 240) / 610;
            const octomap::point3d direction(static_cast<float>(m[0] * x + m[1] * y + m[2]),
                                             static_cast<float>(m[4] * x + m[5] * y + m[6]),
                                             static_cast<float>(m[8] * x + m[9] * y + m[10]));
            octomap::point3d end;
            tree.castRay(origin, direction, end, true, 1.0);
          }
      }
    });
    report("octomap", "planning rays", sizes[s].name, ms * stride);
  }
}

void time_files(const std::vector<Scan>& scans) {
  octomap::OcTree tree = empty_tree(0.005);
  insert(tree, scans, false);
  std::stringstream full, binary;
  report("octomap", "write .ot", "5 mm", least_ms([&] {
           full.str("");
           tree.write(full);
         }));
  report("octomap", "read .ot", "5 mm", least_ms([&] {
           full.clear();
           full.seekg(0);
           delete octomap::AbstractOcTree::read(full);
         }));
  report("octomap", "write .bt", "5 mm", least_ms([&] {
           binary.str("");
           tree.writeBinaryConst(binary);
         }));
  report("octomap", "read .bt", "5 mm", least_ms([&] {
           binary.clear();
           binary.seekg(0);
           octomap::OcTree read(0.1);
           read.readBinary(binary);
         }));
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: octomap WORKLOAD\n");
    return 2;
  }
  const std::string folder = argv[1];
  std::cerr.setstate(std::ios::failbit);  // OctoMap reports every file that it reads
  const std::vector<Scan> a = read_scans(folder, 'A'), b = read_scans(folder, 'B');
  time_insertion(a, "insertion A; per end voxel", true, 4);
  time_insertion(a, "insertion A; every point", false, 3);
  time_insertion(b, "insertion B; per end voxel", true, 1);
  time_insertion(b, "insertion B; every point", false, 1);
  time_rays(folder, a);
  time_files(a);
}
