// SPDX-License-Identifier: BSD-3-Clause
// The kernels of the visibility tests for each set of instructions that this processor has.
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>

#include "visibility/visibility_kernels.hpp"

namespace lidar_mapping::moving_objects {
namespace {

constexpr std::size_t kPoints = 20'000;  // chosen: a key frame after its voxel filter
constexpr int kFirstRow = 330;           // of 0.5 degrees from straight down: -15 degrees
constexpr int kRows = 60;                // up to +15 degrees, as of 16 beams
constexpr int kFarthest = 30'000;        // chosen: 59 m, beyond the farthest vote

/// Points as far as observers vote, in and around the field of view of 16 beams.
struct Points {
  Points() {
    std::mt19937 random(1);
    std::uniform_real_distribution<float> level(-40.0F, 40.0F), height(-6.0F, 6.0F);
    for (std::size_t i = 0; i < kPoints; ++i) {
      x.push_back(level(random));
      y.push_back(level(random));
      z.push_back(height(random));
    }
  }
  PointArrays arrays() const { return {x.data(), y.data(), z.data()}; }

  std::vector<float> x, y, z;
};

const Viewpoint& viewpoint() {
  static const Viewpoint instance = {{1.0F, 0.0F, 0.0F, 0.0F, 1.0F, 0.0F, 0.0F, 0.0F, 1.0F},
                                     {2.0F, -1.0F, 0.5F},
                                     1600.0F,
                                     kFirstRow,
                                     kRows};
  return instance;
}

/// A range image with gaps, as its windows; the last one is for everything outside.
std::vector<RangeInterval> windows() {
  std::mt19937 random(2);
  std::uniform_int_distribution<RangeInterval> nearest(1, kFarthest), depth(0, 2000);
  std::vector<RangeInterval> result;
  for (int i = 0; i < viewpoint().no_pixel(); ++i) {
    const RangeInterval first = nearest(random);
    result.push_back(i % 7 == 0 ? kUnobserved : (first + depth(random)) << 16U | first);
  }
  result.push_back(kUnobserved);
  return result;
}

/// The pixels of all points in the view.
struct Projection {
  ProjectedPixels targets() { return {pixels.data(), nearest.data(), farthest.data()}; }

  std::vector<int> pixels = std::vector<int>(kPoints);
  std::vector<int> nearest = std::vector<int>(kPoints);
  std::vector<int> farthest = std::vector<int>(kPoints);
};

void projection(benchmark::State& state, const VisibilityKernels* kernels) {
  const Points points;
  Projection projected;
  std::vector<int> remaining(kPoints);
  for (auto _ : state) {
    kernels->project_into_view(viewpoint(), points.arrays(), kPoints, projected.targets(),
                               remaining.data());
  }
  state.SetItemsProcessed(static_cast<std::int64_t>(state.iterations() * kPoints));
}

void classification(benchmark::State& state, const VisibilityKernels* kernels) {
  const Points points;
  const std::vector<RangeInterval> image = windows();
  Projection projected;
  std::vector<int> counter(kPoints), through(kPoints), hits(kPoints), ambiguous(kPoints);
  kernels->project_into_view(viewpoint(), points.arrays(), kPoints, projected.targets(),
                             counter.data());
  for (auto _ : state) {
    kernels->classify(image.data(), projected.targets(), kPoints, {through.data(), hits.data()},
                      ambiguous.data());
  }
  state.SetItemsProcessed(static_cast<std::int64_t>(state.iterations() * kPoints));
}

void add(const char* instructions, const VisibilityKernels* kernels) {
  if (kernels == nullptr) return;  // neither the compiler's nor the processor's
  benchmark::RegisterBenchmark((std::string("projection/") + instructions).c_str(), projection,
                               kernels);
  benchmark::RegisterBenchmark((std::string("classification/") + instructions).c_str(),
                               classification, kernels);
}

}  // namespace
}  // namespace lidar_mapping::moving_objects

int main(int argc, char** argv) {
  namespace lm = lidar_mapping::moving_objects;
  lm::add("portable", &lm::portable_visibility_kernels());
  lm::add("avx2", lm::avx2_visibility_kernels());
  lm::add("avx512", lm::avx512_visibility_kernels());
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}
