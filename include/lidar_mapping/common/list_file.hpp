// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <type_traits>
#include <utility>
#include <vector>

#include "lidar_mapping/common/nameless_file.hpp"

namespace lidar_mapping {

/// Lists of values by their keys, in a file without a name that is made with the first of them. The
/// memory holds only where each list lies. Any thread may read. Throws FileError.
template <typename Key, typename Value>
class ListFile {
  static_assert(std::is_trivially_copyable_v<Value>, "the file holds values as memory does");

 public:
  /// The file will be made in `directory`.
  explicit ListFile(std::filesystem::path directory) : directory_(std::move(directory)) {}

  /// Number of lists.
  std::size_t size() const { return places_.size(); }
  /// Whether there is a list of this key.
  bool contains(const Key& key) const { return places_.count(key) > 0; }
  /// All keys that have a list, rising.
  std::vector<Key> keys() const {
    std::vector<Key> keys;
    for (const auto& [key, place] : places_) keys.push_back(key);
    return keys;
  }
  /// Stores a list; may be called once for each key.
  void put(const Key& key, const std::vector<Value>& values) {
    if (!file_) file_ = std::make_unique<NamelessFile>(directory_);
    file_->write(end_ * sizeof(Value), values.data(), values.size() * sizeof(Value));
    places_[key] = {end_, values.size()};
    end_ += values.size();
  }
  /// Reads a list that was stored.
  std::vector<Value> get(const Key& key) const {
    const Place& place = places_.at(key);
    std::vector<Value> values(place.count);
    file_->read(place.begin * sizeof(Value), values.data(), values.size() * sizeof(Value));
    return values;
  }

 private:
  struct Place {
    std::uint64_t begin = 0;  ///< of the first value in the file, in values
    std::size_t count = 0;
  };

  std::filesystem::path directory_;
  std::unique_ptr<NamelessFile> file_;
  std::uint64_t end_ = 0;  ///< length of the file, in values
  std::map<Key, Place> places_;
};

}  // namespace lidar_mapping
