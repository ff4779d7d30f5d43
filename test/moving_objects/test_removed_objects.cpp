// SPDX-License-Identifier: BSD-3-Clause
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "votes/removed_objects.hpp"

namespace lidar_mapping::moving_objects {
namespace {

/// Things from above, one letter for each cell of 0.3 m with a point in it: m votes moving, s
/// static, u is unseen; g is below all that, at the base of an object; a dot is no point.
class Picture {
 public:
  explicit Picture(const std::vector<std::string>& rows) {
    for (std::size_t row = 0; row < rows.size(); ++row) {
      for (std::size_t column = 0; column < rows[row].size(); ++column) {
        if (rows[row][column] == '.') continue;
        add(0.3F * static_cast<float>(column) + 0.15F, 0.3F * static_cast<float>(row) + 0.15F,
            rows[row][column]);
      }
    }
  }
  void add(float x, float y, char letter) {
    cloud_.points.push_back({x, y, 1.0F, 0.0F});
    const Vote seen = letter == 's' ? Vote::kStatic : Vote::kUnseen;
    votes_.push_back(letter == 'm' ? Vote::kMoving : seen);
    layers_.push_back(letter == 'g' ? Layer::kBase : Layer::kBody);
  }

  /// For each point, row by row: x is removed, o touches what is removed, - does neither.
  std::string removed() const {
    const RemovedObjects objects(TransformedPoints(cloud_, Pose()), votes_, layers_);
    std::string result;
    for (std::size_t i = 0; i < cloud_.size(); ++i) {
      const char beside = objects.touches(i) ? 'o' : '-';
      EXPECT_FALSE(objects.contains(i) && beside != 'o') << i;
      result += objects.contains(i) ? 'x' : beside;
    }
    return result;
  }

 private:
  PointCloud cloud_;
  std::vector<Vote> votes_;
  std::vector<Layer> layers_;
};

std::string removed(const std::vector<std::string>& rows) { return Picture(rows).removed(); }

TEST(RemovedObjects, AreThoseOfWhichMoreThanThreeTenthsMove) {
  EXPECT_EQ(removed({"mmssss"}), "xxxxxx");
  EXPECT_EQ(removed({"mmsssss"}), "-------");
  EXPECT_EQ(removed({"mmmsssssss"}), "----------") << "three tenths are not more";
  EXPECT_EQ(removed({"ssssss"}), "------");
}

TEST(RemovedObjects, NeedSixVotersAndTakeTheUnseenAlong) {
  EXPECT_EQ(removed({"mmmmm"}), "-----");
  EXPECT_EQ(removed({"mmmmmu"}), "------") << "who sees nothing has no vote";
  EXPECT_EQ(removed({"mmmmmmuu"}), "xxxxxxxx");
}

TEST(RemovedObjects, ReachAsFarAsTheirCellsTouch) {
  EXPECT_EQ(removed({"mmm...",  //
                     "...sss"}),
            "xxxxxx")
      << "also at corners";
  EXPECT_EQ(removed({"mmm....",  //
                     "....sss"}),
            "------")
      << "two objects of three voters";
  EXPECT_EQ(removed({"mmmmmm.ssssss"}), "xxxxxx------") << "a gap of one cell";
}

TEST(RemovedObjects, AreWholeWhateverTheirShape) {
  EXPECT_EQ(removed({"sss",  //
                     "s.s",  //
                     "m.m",  //
                     "mmm"}),
            std::string(10, 'x'));
}

TEST(RemovedObjects, CountTheirOwnVotesAlone) {
  EXPECT_EQ(removed({"mmmmmm",  //
                     "......",  //
                     "msssss"}),
            "xxxxxx------");
  EXPECT_EQ(removed({"msssss",  //
                     "......",  //
                     "mmmmmm"}),
            "------xxxxxx");
}

TEST(RemovedObjects, AreTouchedByWhatStandsInTheNextCell) {
  EXPECT_EQ(removed({"mmmmmmggssssss"}), "xxxxxxo-------") << "a base joins no objects";
  EXPECT_EQ(removed({"ggg.....",  //
                     "gmmmmmmg",  //
                     "g......g"}),
            "ooooxxxxxxooo");
}

TEST(RemovedObjects, HaveAllPointsOfTheirCells) {
  Picture picture({"mmmmmm"});
  picture.add(0.02F, 0.28F, 's');
  picture.add(-0.02F, 0.28F, 'g');
  picture.add(-0.32F, 0.28F, 'g');
  EXPECT_EQ(picture.removed(), "xxxxxxxo-");
}

TEST(RemovedObjects, LeaveWhatIsOutOfRange) {
  Picture picture({"mmmmmm"});
  for (int i = 0; i < 6; ++i) {
    picture.add(kMaxRange + 1.0F + 0.3F * static_cast<float>(i), 0.0F, 'm');
  }
  EXPECT_EQ(picture.removed(), "xxxxxx------");
  EXPECT_EQ(removed({"gg"}), "--") << "there is no object at all";
}

TEST(CellNumbers, AreNoneUntilTheyAreSet) {
  CellNumbers numbers(100);
  numbers.set(99, 7);
  numbers.set(31, 5);
  numbers.set(32, 6);
  numbers.set(31, 8);
  for (std::uint32_t cell = 0; cell < 100; ++cell) {
    const std::uint32_t expected = cell == 99 ? 7U : cell == 31 ? 8U : cell == 32 ? 6U : 0U;
    EXPECT_EQ(numbers.at(cell), expected) << cell;
  }
}

}  // namespace
}  // namespace lidar_mapping::moving_objects
