// The paper's flow network by a general solver (LEMON's network simplex) and by successive shortest paths found with the
// queue form of Bellman-Ford (SPFA), as in the paper. Both find the largest total quality and say nothing about few views.
//
//   g++ -O3 -march=native -DNDEBUG flow.cpp -o flow
//   ./flow WORKLOAD
#include <lemon/network_simplex.h>
#include <lemon/smart_graph.h>

#include <cmath>
#include <deque>

#include "common.hpp"

namespace {

struct Network {
  int n_views, n_rays, n_voxels, n_edges;
  std::vector<int32_t> view_of_ray, ray, voxel;
  std::vector<double> quality;

  explicit Network(const std::string& path) {
    const std::vector<char> bytes = read_all<char>(path);
    const auto* words = reinterpret_cast<const int32_t*>(bytes.data());
    n_views = words[0], n_rays = words[1], n_voxels = words[2], n_edges = words[3];
    const int32_t* next = words + 4;
    view_of_ray.assign(next, next + n_rays);
    next += n_rays;
    for (int i = 0; i < n_edges; ++i) {
      ray.push_back(next[2 * i]);
      voxel.push_back(next[2 * i + 1]);
    }
    next += 2 * n_edges;
    quality.resize(static_cast<size_t>(n_edges));
    std::copy_n(reinterpret_cast<const char*>(next), 8 * quality.size(), reinterpret_cast<char*>(quality.data()));
  }

  std::vector<int> served_voxels() const {
    std::vector<int> served(voxel.begin(), voxel.end());
    std::sort(served.begin(), served.end());
    served.erase(std::unique(served.begin(), served.end()), served.end());
    return served;
  }
};

// Node numbers: voxels, rays, views, source, sink.
struct Nodes {
  int rays, views, source, sink;
  explicit Nodes(const Network& n)
      : rays(n.n_voxels), views(rays + n.n_rays), source(views + n.n_views), sink(source + 1) {}
};

template <class AddArc>
void add_arcs(const Network& network, AddArc add) {
  const Nodes nodes(network);
  const int unbounded = 1 << 20;
  for (int voxel : network.served_voxels()) add(nodes.source, voxel, 1, 0.0);
  for (size_t i = 0; i < network.ray.size(); ++i) add(network.voxel[i], nodes.rays + network.ray[i], 1, -network.quality[i]);
  for (int ray = 0; ray < network.n_rays; ++ray)
    add(nodes.rays + ray, nodes.views + network.view_of_ray[static_cast<size_t>(ray)], unbounded, 0.0);
  for (int view = 0; view < network.n_views; ++view) add(nodes.views + view, nodes.sink, unbounded, 0.0);
}

double by_network_simplex(const Network& network) {
  const Nodes nodes(network);
  lemon::SmartDigraph graph;
  for (int i = 0; i <= nodes.sink; ++i) graph.addNode();
  std::vector<int> capacities;
  // Whole numbers: with floating-point costs the simplex method may go round in circles.
  std::vector<int64_t> costs;
  add_arcs(network, [&](int from, int to, int capacity, double cost) {
    graph.addArc(graph.nodeFromId(from), graph.nodeFromId(to));
    capacities.push_back(capacity);
    costs.push_back(std::llround(1e9 * cost));
  });
  lemon::SmartDigraph::ArcMap<int> capacity(graph);
  lemon::SmartDigraph::ArcMap<int64_t> cost(graph);
  for (size_t i = 0; i < costs.size(); ++i) {
    capacity[graph.arcFromId(static_cast<int>(i))] = capacities[i];
    cost[graph.arcFromId(static_cast<int>(i))] = costs[i];
  }
  lemon::NetworkSimplex<lemon::SmartDigraph, int, int64_t> solver(graph);
  const int amount = static_cast<int>(network.served_voxels().size());
  solver.upperMap(capacity).costMap(cost).stSupply(graph.nodeFromId(nodes.source), graph.nodeFromId(nodes.sink), amount);
  solver.run();
  return -1e-9 * static_cast<double>(solver.totalCost<int64_t>());
}

class Residual {
 public:
  explicit Residual(const Network& network) : nodes_(network), out_(static_cast<size_t>(nodes_.sink) + 1) {
    add_arcs(network, [&](int from, int to, int capacity, double cost) {
      out_[static_cast<size_t>(from)].push_back(static_cast<int>(arcs_.size()));
      arcs_.push_back({to, capacity, cost});
      out_[static_cast<size_t>(to)].push_back(static_cast<int>(arcs_.size()));
      arcs_.push_back({from, 0, -cost});
    });
  }

  // Sends one unit along the cheapest path; false if there is none.
  bool augment(double& total_cost) {
    const size_t n = out_.size();
    std::vector<double> distance(n, INFINITY);
    std::vector<int> entered_by(n, -1);
    std::vector<char> is_queued(n, 0);
    std::deque<int> queue{nodes_.source};
    distance[static_cast<size_t>(nodes_.source)] = 0;
    while (!queue.empty()) {
      const int node = queue.front();
      queue.pop_front();
      is_queued[static_cast<size_t>(node)] = 0;
      for (int index : out_[static_cast<size_t>(node)]) {
        const Arc& arc = arcs_[static_cast<size_t>(index)];
        const double through = distance[static_cast<size_t>(node)] + arc.cost;
        const size_t to = static_cast<size_t>(arc.to);
        // Without the tolerance, rounding makes circles of zero cost look cheaper for ever.
        if (arc.capacity > 0 && through < distance[to] - 1e-12) {
          distance[to] = through;
          entered_by[to] = index;
          if (!is_queued[to]) {
            is_queued[to] = 1;
            queue.push_back(arc.to);
          }
        }
      }
    }
    if (entered_by[static_cast<size_t>(nodes_.sink)] < 0) return false;
    total_cost += distance[static_cast<size_t>(nodes_.sink)];
    for (int node = nodes_.sink; node != nodes_.source;) {
      const int index = entered_by[static_cast<size_t>(node)];
      arcs_[static_cast<size_t>(index)].capacity -= 1;
      arcs_[static_cast<size_t>(index ^ 1)].capacity += 1;
      node = arcs_[static_cast<size_t>(index ^ 1)].to;
    }
    return true;
  }

 private:
  struct Arc {
    int to, capacity;
    double cost;
  };
  Nodes nodes_;
  std::vector<Arc> arcs_;
  std::vector<std::vector<int>> out_;
};

double by_spfa(const Network& network) {
  Residual residual(network);
  double cost = 0;
  while (residual.augment(cost)) {
  }
  return -cost;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: flow WORKLOAD\n");
    return 2;
  }
  const std::string folder = argv[1];
  for (const char* size : {"small", "large"}) {
    const Network network(folder + "/network_" + size + ".bin");
    const std::string which = std::to_string(network.n_rays) + " rays";
    double quality = 0;
    report("lemon", "flow and cover", which, least_ms([&] { quality = by_network_simplex(network); }, 1));
    std::fprintf(stderr, "lemon: quality %.9f of %zu voxels\n", quality, network.served_voxels().size());
    if (std::string(size) == "small") {
      report("spfa", "flow and cover", which, least_ms([&] { quality = by_spfa(network); }, 1));
      std::fprintf(stderr, "spfa: quality %.9f\n", quality);
    }
  }
}
