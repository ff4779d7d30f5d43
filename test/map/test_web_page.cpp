// SPDX-License-Identifier: BSD-3-Clause
// The page in a browser: its files, and what Chromium shows of them (check_web_page.py).
#include <fstream>

#include <gtest/gtest.h>

#include "lidar_mapping/common/errors.hpp"

#include "error_text.hpp"
#include "file_content.hpp"
#include "files/ept_file.hpp"
#include "temporary_folder.hpp"
#include "web/web_page.hpp"

namespace lidar_mapping::map {
namespace {

namespace fs = std::filesystem;
using test::content_of;
using test::TemporaryFolder;

constexpr GeodeticDatum kDatum{-33.9, 18.4, 30.0};
constexpr int kSkipped = 77;  // of check_web_page.py: there is no browser

/// A square with a wall, a point every 0.1 m.
void pass_square(const TileSink& sink) {
  MapTile tile;
  for (int i = 0; i < 300; ++i) {
    for (int k = 0; k < 300; ++k) {
      const float u = 0.1F * static_cast<float>(i);
      const float v = 0.1F * static_cast<float>(k);
      tile.cloud.points.push_back({u, v, 0.0F, 0.5F});
      if (k < 50) tile.cloud.points.push_back({u, 30.0F, v, 1.0F});
    }
  }
  sink(tile);
}

WebPage example_page() {
  WebPage page;
  page.title = "</script>\"square\"";  // as harmless as any other name of a map
  page.datum = kDatum;
  page.resolution = 0.1;
  page.marks.path = {{0, 0, 0, {1.0, 1.0, 1.0}}, {1, 0, 1, {20.0, 20.0, 1.0}}};
  page.marks.loops = {{0, 1, Verdict::kAccepted, "", LoopSource::kPosition}};
  DoubtMark doubt;
  doubt.kind = "degenerate";
  doubt.path_map = {{5.0, 5.0, 1.0}, {8.0, 8.0, 1.0}};
  page.marks.doubts = {doubt};
  constexpr Stamp kDay = 86'400'000'000'000;
  using moving_objects::ChangeKind;
  page.visits = {{0, kDay / 4}, {kDay, kDay + kDay / 4}, {2 * kDay, 2 * kDay}};
  page.changes = {{ChangeKind::kAppeared, 0, 1, {10.0, 10.0, 0.0}, {14.0, 12.0, 1.5}, {}},
                  {ChangeKind::kDisappeared, 2, 1, {20.0, 5.0, 0.0}, {21.0, 6.0, 3.0}, {}}};
  return page;
}

class Web : public testing::Test {
 protected:
  void SetUp() override {
    if (!web_obstacle().empty()) GTEST_SKIP() << web_obstacle();
    EptOptions options;
    options.datum = kDatum;
    options.origin = [](KeyFrameIndex) { return PointOrigin{}; };
    write_ept(pass_square, options, folder_.path());
    add_web_page(example_page(), folder_.path());
  }
  const TemporaryFolder folder_;
};

TEST_F(Web, HasAllFilesThatItNames) {
  const std::string page = content_of(folder_.path() / "index.html");
  for (const char* name : {"viewer/style.css", "viewer/three.min.js", "viewer/marks.js",
                           "viewer/viewer.js", "viewer/overview.js"}) {
    EXPECT_GT(fs::file_size(folder_.path() / name), 100U) << name;
    if (std::string(name) != "viewer/overview.js") {
      EXPECT_NE(page.find(name), std::string::npos) << name << " is not in the page";
    }
  }
  EXPECT_EQ(page.find("://"), std::string::npos) << "the page asks no other host";
  EXPECT_NE(content_of(folder_.path() / "viewer" / "marks.js").find("\"epsg\":32734"),
            std::string::npos);
}

TEST_F(Web, RunsInChromium) {
  const int status =
      std::system(("python3 map/check_web_page.py " + folder_.path().string()).c_str());
  if (WEXITSTATUS(status) == kSkipped) GTEST_SKIP() << "chromium is not installed";
  EXPECT_EQ(status, 0);
}

TEST(Three, IsMissingWithARemedy) {
  const TemporaryFolder folder;
  const std::vector<fs::path> places = {folder.path() / "a.js", folder.path() / "b.js"};
  const std::string problem = test::error_text<InputError>([&] { find_three(places); });
  EXPECT_NE(problem.find("install the package libjs-three"), std::string::npos) << problem;
  std::ofstream(places[1]) << "//";
  EXPECT_EQ(find_three(places), places[1]);
}

}  // namespace
}  // namespace lidar_mapping::map
