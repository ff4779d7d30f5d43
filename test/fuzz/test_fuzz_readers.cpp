// SPDX-License-Identifier: BSD-3-Clause
// Spoilt files of every kind through the functions that read them, in this process: nothing but
// this package's own errors comes back, nothing hangs, and what is taken is made of finite numbers.
// FUZZ_SECONDS (of each kind) and FUZZ_SEED of the environment let it run longer and elsewhere.
#include <algorithm>
#include <cstdio>
#include <ctime>
#include <fstream>

#include <gtest/gtest.h>

#include "lidar_mapping/common/errors.hpp"

#include "file_content.hpp"
#include "fuzz_options.hpp"
#include "mutation.hpp"
#include "reader_kinds.hpp"
#include "temporary_folder.hpp"

namespace lidar_mapping::test {

namespace fs = std::filesystem;

void PrintTo(const ReaderKind& kind, std::ostream* out) { *out << kind.name; }

namespace {

double processor_seconds() {
  return static_cast<double>(std::clock()) / static_cast<double>(CLOCKS_PER_SEC);
}

/// Spoils one file of the folder after the other.
class Campaign {
 public:
  Campaign(const ReaderKind& kind, std::uint32_t seed) : kind_(kind), engine_(seed) {
    fs::create_directory(whole_);
    kind_.write(whole_);
    files_ = files_to_spoil(kind_, whole_);
  }

  void run(double seconds) {
    std::printf("%s: spoilt files in %s\n", kind_.name.c_str(), folder_.path().c_str());
    std::fflush(stdout);
    fs::copy(whole_, folder_.path() / "as_written", fs::copy_options::recursive);
    kind_.read(folder_.path() / "as_written");
    const double end = processor_seconds() + seconds;
    while (processor_seconds() < end || cases_ < kLeastCases) spoil_one();
    std::printf("%s: %zu cases, %zu refused\n", kind_.name.c_str(), cases_, refused_);
  }

 private:
  static constexpr std::size_t kLeastCases = 60;
  static constexpr double kLongest = 20.0;  // s of processor time for one case

  void spoil_one() {
    ++cases_;
    const fs::path spoilt = folder_.path() / "spoilt";
    fs::remove_all(spoilt);
    fs::copy(whole_, spoilt, fs::copy_options::recursive);
    const fs::path file = files_[engine_() % files_.size()];
    spoil(spoilt / file);
    const double begin = processor_seconds();
    try {
      kind_.read(spoilt);
    } catch (const Error& error) {
      ++refused_;
      EXPECT_GT(std::string(error.what()).size(), 10U);
    } catch (const std::exception& error) {
      keep(spoilt, std::string("not an error of this package: ") + error.what());
    }
    if (processor_seconds() - begin > kLongest) keep(spoilt, "it takes too long");
  }

  void spoil(const fs::path& file) {
    if (kind_.spoil) return kind_.spoil(file, engine_);
    const std::string spoilt = mutated(content_of(file), engine_);
    std::ofstream(file, std::ios::binary) << spoilt;
  }

  void keep(const fs::path& spoilt, const std::string& problem) const {
    const fs::path kept = fs::temp_directory_path() /
                          ("lidar_mapping_finding_" + kind_.name + "_" + std::to_string(cases_));
    fs::remove_all(kept);
    fs::copy(spoilt, kept, fs::copy_options::recursive);
    ADD_FAILURE() << kind_.name << ", case " << cases_ << ": " << problem << "; see " << kept;
  }

  const ReaderKind& kind_;
  std::mt19937 engine_;
  TemporaryFolder folder_;
  fs::path whole_ = folder_.path() / "whole";
  std::vector<fs::path> files_;
  std::size_t cases_ = 0;
  std::size_t refused_ = 0;
};

class FuzzReaders : public testing::TestWithParam<ReaderKind> {};

TEST_P(FuzzReaders, DoNotCrashOnDamagedFiles) {
  const FuzzOptions options = fuzz_options();
  std::printf("seed %u\n", options.seed);
  Campaign(GetParam(), options.seed).run(options.seconds);
}

INSTANTIATE_TEST_SUITE_P(All, FuzzReaders, testing::ValuesIn(reader_kinds()),
                         [](const auto& kind) { return kind.param.name; });

}  // namespace
}  // namespace lidar_mapping::test
