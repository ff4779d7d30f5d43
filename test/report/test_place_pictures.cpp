// SPDX-License-Identifier: BSD-3-Clause
// The report shows something of every place.
#include <random>

#include <gtest/gtest.h>

#include "place_pictures.hpp"

namespace lidar_mapping::report {
namespace {

/// Points all over a box between two corners, m.
std::vector<Eigen::Vector3f> scattered(const Eigen::Vector3f& low, const Eigen::Vector3f& high) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> share(0.0F, 1.0F);
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i < 2000; ++i) {
    const Eigen::Array3f at(share(random), share(random), share(random));
    points.push_back((low.array() + at * (high - low).array()).matrix());
  }
  return points;
}

void expect_both_passes(const map_quality::PassPoints& points, View view,
                        const std::string& title) {
  const json::Json picture = place_picture(points, view);
  EXPECT_EQ(picture["title"].get<std::string>(), title);
  ASSERT_EQ(picture["passes"].size(), 2U);
  for (const json::Json& pass : picture["passes"]) EXPECT_GE(pass.size(), 300U);
}

TEST(PlacePicture, IsANarrowSliceWhereThatShowsBothPasses) {
  const auto around = scattered({-10.0F, -10.0F, 0.0F}, {10.0F, 10.0F, 4.0F});
  const map_quality::PassPoints points{around, around};
  expect_both_passes(points, View::kFromAbove, "From above, 0.5 to 3 m up");
}

TEST(PlacePicture, IsWiderWhereOnlyGroundWasSeen) {
  const auto ground = scattered({-10.0F, -10.0F, -0.1F}, {10.0F, 10.0F, 0.1F});
  const map_quality::PassPoints points{ground, ground};
  expect_both_passes(points, View::kFromAbove, "From above");
}

TEST(PlacePicture, IsWiderWhereAPassWasSeenFromAfar) {
  const map_quality::PassPoints points{scattered({8.0F, -10.0F, 0.0F}, {25.0F, 10.0F, 4.0F}),
                                       scattered({-10.0F, -10.0F, 0.0F}, {10.0F, 10.0F, 4.0F})};
  expect_both_passes(points, View::kAcross, "Across, a slice of 30 m");
}

}  // namespace
}  // namespace lidar_mapping::report
