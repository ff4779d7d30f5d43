// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/common/pcd_header.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <numeric>
#include <sstream>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/input_file.hpp"
#include "lidar_mapping/common/number_words.hpp"
#include "lidar_mapping/common/text.hpp"

namespace lidar_mapping {

namespace {

/// As the format wants them. VERSION, COUNT and VIEWPOINT may be missing.
constexpr std::array<const char*, 10> kOrder = {"VERSION", "FIELDS", "SIZE",      "TYPE",   "COUNT",
                                                "WIDTH",   "HEIGHT", "VIEWPOINT", "POINTS", "DATA"};
constexpr std::size_t kLongestHeader = 100'000;    // bytes; chosen: far above ten lines of fields
constexpr std::size_t kMostBytes = 4'000'000'000;  // of points, because PCL counts them in 32 bits
constexpr std::size_t kMostNumbers = 10'000;       // of a field; chosen: descriptors have hundreds
constexpr std::size_t kViewpoint = 7;              // numbers, by the format: position, quaternion
constexpr std::size_t kCompressedSizes = 2 * sizeof(std::uint32_t);  // bytes, by the format

class HeaderReader {
 public:
  explicit HeaderReader(const std::filesystem::path& path)
      : path_(path), file_(open_for_reading(path)) {}

  PcdHeader read() {
    std::string line;
    while (header_.data.empty()) {
      if (!std::getline(file_, line)) fail("the header has no line DATA");
      ++number_;
      header_.text += line + "\n";
      if (header_.text.size() > kLongestHeader) fail("the header has no end");
      parse_line(line);
    }
    if (header_.points > 0) check_length();
    return std::move(header_);
  }

 private:
  [[noreturn]] void fail(const std::string& problem) const {
    throw FileError("cannot read " + path_.string() + ":" + std::to_string(number_) + ": " +
                    problem + "; it is no PCD file or a damaged one");
  }

  void parse_line(const std::string& line) {
    std::istringstream stream(line);
    std::string key;
    stream >> key;
    if (line.empty() || (!key.empty() && key[0] == '#')) return;
    if (key.empty()) fail("a line of white space, which ends the header for PCL");
    const auto place = std::find(kOrder.begin(), kOrder.end(), key);
    if (place == kOrder.end()) fail("'" + key.substr(0, 40) + "' is no line of a header");
    if (place < next_) fail(key + " is given twice or after " + *(next_ - 1));
    for (; next_ != place; ++next_) require_optional(*next_);
    ++next_;
    words_.clear();
    for (std::string word; stream >> word;) words_.push_back(word);
    use(key);
  }

  void require_optional(const std::string& key) const {
    if (key == "VERSION" || key == "COUNT" || key == "VIEWPOINT") return;
    fail("there is no line " + key + " before this one");
  }

  void use(const std::string& key) {
    if (key == "FIELDS") return use_names();
    if (key == "SIZE") return use_sizes();
    if (key == "TYPE") return use_types();
    if (key == "COUNT") return use_counts();
    if (key == "WIDTH") width_ = only_number(key);
    if (key == "HEIGHT") height_ = only_number(key);
    if (key == "VIEWPOINT") return use_viewpoint();
    if (key == "POINTS") return use_points();
    if (key == "DATA") return use_data();
  }

  void use_names() {
    if (words_.empty()) fail("FIELDS names none");
    for (const std::string& name : words_) header_.fields.push_back({name, 0, 'F', 1});
  }

  void use_sizes() {
    const std::vector<std::size_t> sizes = numbers_of_fields("SIZE");
    for (std::size_t i = 0; i < sizes.size(); ++i) {
      const std::size_t size = sizes[i];
      if (size != 1 && size != 2 && size != 4 && size != 8) fail("SIZE is to be 1, 2, 4 or 8");
      header_.fields[i].size = size;
    }
  }

  void use_types() {
    check_number("TYPE");
    for (std::size_t i = 0; i < words_.size(); ++i) {
      PcdField& field = header_.fields[i];
      field.type = words_[i][0];
      const bool is_type = words_[i].size() == 1 && std::strchr("FUI", field.type) != nullptr;
      if (!is_type || (field.type == 'F' && field.size < 4)) {
        fail("TYPE " + words_[i].substr(0, 40) + " of " + std::to_string(field.size) +
             " bytes does not exist; there are F, U and I");
      }
    }
  }

  void use_counts() {
    const std::vector<std::size_t> counts = numbers_of_fields("COUNT");
    for (std::size_t i = 0; i < counts.size(); ++i) {
      if (counts[i] == 0 || counts[i] > kMostNumbers) {
        fail("COUNT is to be between 1 and " + std::to_string(kMostNumbers));
      }
      header_.fields[i].count = counts[i];
    }
  }

  void use_viewpoint() const {
    if (words_.size() != kViewpoint) fail("VIEWPOINT is to have seven numbers");
    try {
      for (const std::string& word : words_) finite_number(word);
    } catch (const InputError& error) {
      fail(std::string("VIEWPOINT: ") + error.what());
    }
  }

  void use_points() {
    header_.points = only_number("POINTS");
    const bool fits = height_ == 0
                          ? header_.points == 0
                          : header_.points % height_ == 0 && header_.points / height_ == width_;
    if (!fits) {
      fail("POINTS is " + std::to_string(header_.points) + ", but WIDTH " + std::to_string(width_) +
           " and HEIGHT " + std::to_string(height_));
    }
    header_.width = width_;
    if (header_.points > kMostBytes / header_.step()) fail("there are too many POINTS");
  }

  void use_data() {
    const bool is_kind = words_.size() == 1 && (words_[0] == "ascii" || words_[0] == "binary" ||
                                                words_[0] == "binary_compressed");
    if (!is_kind) fail("DATA is to be ascii, binary or binary_compressed");
    header_.data = words_[0];
  }

  void check_number(const std::string& key) const {
    if (words_.size() == header_.fields.size()) return;
    fail(key + " has " + std::to_string(words_.size()) + " words for " +
         std::to_string(header_.fields.size()) + " FIELDS");
  }

  std::size_t number(const std::string& key, const std::string& word) const {
    std::uint32_t value = 0;
    const char* const end = word.data() + word.size();
    const auto result = std::from_chars(word.data(), end, value);
    if (result.ec != std::errc() || result.ptr != end) {
      fail(key + ": '" + word.substr(0, 40) + "' is no number of points or bytes");
    }
    return value;
  }

  std::size_t only_number(const std::string& key) const {
    if (words_.size() != 1) fail(key + " is to have one number");
    return number(key, words_[0]);
  }

  std::vector<std::size_t> numbers_of_fields(const std::string& key) const {
    check_number(key);
    std::vector<std::size_t> numbers;
    for (const std::string& word : words_) numbers.push_back(number(key, word));
    return numbers;
  }

  void check_length() {
    const std::size_t there = bytes_behind();
    if (header_.data == "binary") return require(header_.points * header_.step(), there);
    if (header_.data == "ascii") {
      std::size_t numbers = 0;
      for (const PcdField& field : header_.fields) numbers += field.count;
      return require(header_.points * 2 * numbers - 1, there);  // a digit and white space each
    }
    require(kCompressedSizes, there);
    std::array<std::uint32_t, 2> sizes{};  // compressed, uncompressed
    file_.read(reinterpret_cast<char*>(sizes.data()), kCompressedSizes);
    require(kCompressedSizes + sizes[0], there);
    if (!file_ || sizes[1] != header_.points * header_.step()) {
      fail("the size of the compressed points is not that of the header");
    }
  }

  std::size_t bytes_behind() const {
    const std::size_t all = std::filesystem::file_size(path_);
    return all - std::min(all, header_.text.size());
  }

  void require(std::size_t bytes, std::size_t there) const {
    if (there >= bytes) return;
    fail("its end is missing: " + std::to_string(there) + " bytes for " +
         std::to_string(header_.points) + " points of " + std::to_string(header_.step()));
  }

  std::filesystem::path path_;
  std::ifstream file_;
  std::size_t number_ = 0;
  std::vector<std::string> words_;  ///< of the line, behind its key
  decltype(kOrder)::const_iterator next_ = kOrder.begin();
  std::size_t width_ = 0;
  std::size_t height_ = 0;
  PcdHeader header_;
};

}  // namespace

std::string pcd_header(std::size_t points, const std::string& data) {
  const std::string count = std::to_string(points);
  return "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z intensity\n"
         "SIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1\nWIDTH " +
         count + "\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS " + count + "\nDATA " + data + "\n";
}

std::size_t PcdHeader::step() const {
  return std::accumulate(
      fields.begin(), fields.end(), std::size_t{0},
      [](std::size_t sum, const PcdField& field) { return sum + field.size * field.count; });
}

bool PcdHeader::has_float_coordinates() const {
  const auto is_there = [this](const char* name) {
    return std::any_of(fields.begin(), fields.end(), [&](const PcdField& field) {
      return field.name == name && field.type == 'F' && field.size == 4 && field.count == 1;
    });
  };
  return is_there("x") && is_there("y") && is_there("z");
}

bool PcdHeader::has_more_fields() const {
  std::vector<std::string> names;
  for (const PcdField& field : fields) names.push_back(field.name);
  const std::string written = joined(names, " ");
  return written != "x y z" && written != "x y z intensity";
}

PcdHeader read_pcd_header(const std::filesystem::path& path) { return HeaderReader(path).read(); }

}  // namespace lidar_mapping
