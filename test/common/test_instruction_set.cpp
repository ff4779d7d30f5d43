// SPDX-License-Identifier: BSD-3-Clause
#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <initializer_list>
#include <iterator>
#include <set>
#include <sstream>
#include <string>

#include <gtest/gtest.h>

#include "lidar_mapping/common/instruction_set.hpp"

#include "temporary_folder.hpp"

namespace lidar_mapping {
namespace {

/// What Linux says of the first processor; empty where it is no x86.
std::set<std::string> flags_of_processor() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    if (line.rfind("flags", 0) != 0) continue;
    std::istringstream words(line.substr(line.find(':') + 1));
    return {std::istream_iterator<std::string>(words), {}};
  }
  return {};
}

bool has_all(const std::set<std::string>& flags, std::initializer_list<const char*> wanted) {
  bool all = true;
  for (const char* flag : wanted) all = all && flags.count(flag) > 0;
  return all;
}

TEST(InstructionSets, AreThoseThatTheProcessorHas) {
  const std::set<std::string> flags = flags_of_processor();
  EXPECT_EQ(processor_has(InstructionSet::kAvx2), has_all(flags, {"avx2", "fma"}));
  EXPECT_EQ(processor_has(InstructionSet::kAvx512),
            has_all(flags, {"avx512f", "avx512bw", "avx512dq", "avx512vl", "avx512vbmi", "fma"}));
}

/// A compiler that knows all flags but one.
std::filesystem::path compiler_without(const std::string& flag, const std::filesystem::path& path) {
  std::ofstream(path) << "#!/bin/sh\ncase \" $* \" in *\" " << flag << " \"*) echo \"unknown "
                      << flag << "\" >&2; exit 1;; esac\n"
                      << "exec c++ \"$@\"\n";
  std::filesystem::permissions(path, std::filesystem::perms::owner_all);
  return path;
}

/// What CMake says of the kernels of the project, with such a compiler.
std::string kernels_without(const std::string& flag) {
  const test::TemporaryFolder folder;
  const auto compiler = compiler_without(flag, folder.path() / "compiler");
  const std::string command = "cmake -S common/kernel_project -B " +
                              (folder.path() / "build").string() +
                              " -DCMAKE_CXX_COMPILER=" + compiler.string() + " 2>&1";
  FILE* const pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) return {};
  std::string output;
  std::array<char, 4096> part{};
  while (const std::size_t size = fread(part.data(), 1, part.size(), pipe)) {
    output.append(part.data(), size);
  }
  EXPECT_EQ(pclose(pipe), 0) << output;
  return output;
}

// Each set of flags is asked for as a whole and under its own name.
TEST(InstructionSets, AreCompiledForOnlyWhereTheCompilerKnowsAllTheirFlags) {
  if (flags_of_processor().empty()) GTEST_SKIP() << "no compiler for x86 here";
  const std::string none = "defines NOTFOUND";
  const std::string avx2 =
      "avx2.cpp: -O3 -ffp-contract=off -mavx2 -mfma defines LIDAR_MAPPING_HAS_AVX2";
  const auto contains = [](const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
  };
  const std::string narrow = kernels_without("-mavx512bw");
  EXPECT_TRUE(contains(narrow, "plain.cpp: -O3 -ffp-contract=off " + none)) << narrow;
  EXPECT_TRUE(contains(narrow, avx2)) << narrow;
  EXPECT_TRUE(contains(narrow, "avx512.cpp: -ffp-contract=off " + none)) << narrow;
  const std::string wide = kernels_without("-mnothing");
  EXPECT_TRUE(contains(wide, avx2)) << wide;
  EXPECT_TRUE(contains(wide, "defines LIDAR_MAPPING_HAS_AVX512")) << wide;
}

}  // namespace
}  // namespace lidar_mapping
