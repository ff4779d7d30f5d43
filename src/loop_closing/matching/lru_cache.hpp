// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <list>
#include <unordered_map>
#include <utility>

#include "lidar_mapping/common/key_frame.hpp"

namespace lidar_mapping::loop_closing {

/// A least-recently-used cache of data of key frames, limited by their total weight.
template <typename Value>
class LruCache {
 public:
  explicit LruCache(std::size_t capacity) : capacity_(capacity) {}

  /// The value of a key frame; null if it is not in the cache.
  const Value* find(KeyFrameIndex index) {
    const auto found = at_index_.find(index);
    if (found == at_index_.end()) return nullptr;
    newest_first_.splice(newest_first_.begin(), newest_first_, found->second);
    return &found->second->value;
  }

  /// Adds the value of a key frame that is not in the cache. Values that were not used for the
  /// longest time are removed while the total weight is above the capacity.
  const Value& insert(KeyFrameIndex index, Value value, std::size_t weight) {
    newest_first_.push_front({index, std::move(value), weight});
    at_index_[index] = newest_first_.begin();
    weight_ += weight;
    while (weight_ > capacity_ && newest_first_.size() > 1) evict_oldest();
    return newest_first_.front().value;
  }

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

  void evict_oldest() {
    weight_ -= newest_first_.back().weight;
    at_index_.erase(newest_first_.back().index);
    newest_first_.pop_back();
  }

  std::size_t capacity_;
  std::size_t weight_ = 0;
  std::list<Entry> newest_first_;
  std::unordered_map<KeyFrameIndex, typename std::list<Entry>::iterator> at_index_;
};

}  // namespace lidar_mapping::loop_closing
