// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <iterator>
#include <list>
#include <unordered_map>
#include <utility>

#include "lidar_mapping/common/key_frame.hpp"

namespace lidar_mapping {

/// A least-recently-used cache of data of key frames, limited by their total weight.
template <typename Value>
class LruCache {
 public:
  /// `capacity`: greatest total weight.
  explicit LruCache(std::size_t capacity) : capacity_(capacity) {}

  /// The value of a key frame; null if it is not in the cache.
  const Value* find(KeyFrameIndex index) {
    const auto found = at_index_.find(index);
    if (found == at_index_.end()) return nullptr;
    newest_first_.splice(newest_first_.begin(), newest_first_, found->second);
    return &found->second->value;
  }
  /// The same, which does not count as a use.
  const Value* peek(KeyFrameIndex index) const {
    const auto found = at_index_.find(index);
    return found == at_index_.end() ? nullptr : &found->second->value;
  }

  /// Sets the value of a key frame. Values that were not used for the longest time are removed
  /// while the total weight is above the capacity.
  void insert(KeyFrameIndex index, Value value, std::size_t weight) {
    if (const auto known = at_index_.find(index); known != at_index_.end()) remove(known->second);
    newest_first_.push_front({index, std::move(value), weight});
    at_index_[index] = newest_first_.begin();
    weight_ += weight;
    set_capacity(capacity_);
  }
  /// Changes the capacity.
  void set_capacity(std::size_t capacity) {
    capacity_ = capacity;
    while (weight_ > capacity_) remove(std::prev(newest_first_.end()));
  }

  /// Total weight.
  std::size_t weight() const { return weight_; }
  /// Removes all values.
  void clear() {
    newest_first_.clear();
    at_index_.clear();
    weight_ = 0;
  }

 private:
  struct Entry {
    KeyFrameIndex index;
    Value value;
    std::size_t weight;
  };
  using Position = typename std::list<Entry>::iterator;

  void remove(Position entry) {
    weight_ -= entry->weight;
    at_index_.erase(entry->index);
    newest_first_.erase(entry);
  }

  std::size_t capacity_;
  std::size_t weight_ = 0;
  std::list<Entry> newest_first_;
  std::unordered_map<KeyFrameIndex, Position> at_index_;
};

}  // namespace lidar_mapping
