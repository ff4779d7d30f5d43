// SPDX-License-Identifier: BSD-3-Clause
// The readers for libFuzzer (clang), which looks for inputs that reach new places in the code:
//   FUZZ_KIND=pcd_ascii FUZZ_SEEDS=CORPUS fuzz_target CORPUS -max_total_time=60
// The first byte of an input chooses the file of the kind, where it has several; the rest is what
// stands in it. An error of the package is what a reader is to give; all else ends the program.
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <memory>

#include "lidar_mapping/common/errors.hpp"

#include "file_content.hpp"
#include "reader_kinds.hpp"
#include "temporary_folder.hpp"

namespace lidar_mapping::test {
namespace {

namespace fs = std::filesystem;

class Target {
 public:
  explicit Target(const ReaderKind& kind) : kind_(kind) {
    fs::create_directory(whole_);
    kind_.write(whole_);
    files_ = files_to_spoil(kind_, whole_);
  }

  /// The whole files as inputs to begin with.
  void write_seeds(const fs::path& folder) const {
    fs::create_directories(folder);
    for (std::size_t i = 0; i < files_.size(); ++i) {
      std::ofstream(folder / ("whole_" + std::to_string(i)), std::ios::binary)
          << static_cast<char>(i) << content_of(whole_ / files_[i]);
    }
  }

  void read(const std::uint8_t* data, std::size_t size) const {
    const fs::path folder = folder_.path() / "spoilt";
    fs::remove_all(folder);
    fs::copy(whole_, folder, fs::copy_options::recursive);
    const std::string content(reinterpret_cast<const char*>(data) + 1, size - 1);
    std::ofstream(folder / files_[data[0] % files_.size()], std::ios::binary) << content;
    try {
      kind_.read(folder);
    } catch (const Error&) {
    }
  }

 private:
  const ReaderKind& kind_;
  TemporaryFolder folder_;
  fs::path whole_ = folder_.path() / "whole";
  std::vector<fs::path> files_;
};

std::unique_ptr<Target> target;

/// FUZZ_KIND; with a wrong one, all names.
const ReaderKind& wanted_kind() {
  const char* name = std::getenv("FUZZ_KIND");
  for (const ReaderKind& kind : reader_kinds()) {
    if (name != nullptr && kind.name == name) return kind;
  }
  for (const ReaderKind& kind : reader_kinds()) {
    if (!kind.spoil) std::printf("%s\n", kind.name.c_str());
  }
  std::exit(1);
}

}  // namespace
}  // namespace lidar_mapping::test

extern "C" int LLVMFuzzerInitialize(int*, char***) {
  using namespace lidar_mapping::test;
  target = std::make_unique<Target>(wanted_kind());
  if (const char* folder = std::getenv("FUZZ_SEEDS")) target->write_seeds(folder);
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size > 0) lidar_mapping::test::target->read(data, size);
  return 0;
}
