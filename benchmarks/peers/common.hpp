// What the peers share: reading the plain files of a workload, CPU time, and the lines that are printed.
#pragma once
#include <ctime>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

template <class T>
std::vector<T> read_all(const std::string& path) {
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  if (!file) {
    std::fprintf(stderr, "cannot read %s\n", path.c_str());
    std::exit(1);
  }
  std::vector<T> values(static_cast<size_t>(file.tellg()) / sizeof(T));
  file.seekg(0);
  file.read(reinterpret_cast<char*>(values.data()), static_cast<std::streamsize>(values.size() * sizeof(T)));
  return values;
}

inline double cpu_seconds() {
  timespec now;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

// The least CPU time of several runs in milliseconds: at least two runs, more until half a second is spent.
inline double least_ms(const std::function<void()>& work, int min_runs = 2) {
  double least = 1e300, spent = 0;
  for (int run = 0; run < min_runs || spent < 0.5; ++run) {
    const double start = cpu_seconds();
    work();
    const double seconds = cpu_seconds() - start;
    least = std::min(least, seconds);
    spent += seconds;
  }
  return 1e3 * least;
}

inline void report(const char* peer, const char* stage, const std::string& which, double ms) {
  std::printf("%s,%s,%s,%.4f\n", peer, stage, which.c_str(), ms);
  std::fflush(stdout);
}

struct VoxelSize {
  double metres;
  const char* name;
};

constexpr int n_images = 10;

// A camera pose as a row-major 4 x 4 matrix, world from camera.
struct Poses {
  std::vector<double> numbers;
  size_t size() const { return numbers.size() / 16; }
  const double* operator[](size_t i) const { return &numbers[16 * i]; }
};

struct Cloud {
  std::vector<float> xyz;
  double origin[3];
  size_t size() const { return xyz.size() / 3; }
};

inline std::vector<Cloud> read_clouds(const std::string& folder, char set) {
  const Poses poses{read_all<double>(folder + "/poses.f64")};
  std::vector<Cloud> clouds;
  for (int i = 0; i < n_images; ++i) {
    const double* pose = poses[static_cast<size_t>(i)];
    const std::string path = folder + "/cloud" + set + "_" + std::to_string(i) + ".f32";
    clouds.push_back({read_all<float>(path), {pose[3], pose[7], pose[11]}});
  }
  return clouds;
}
