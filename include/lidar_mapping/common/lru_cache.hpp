// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <list>
#include <map>
#include <utility>

namespace lidar_mapping {

/// A least-recently-used cache of values by their keys, limited by their total weight.
template <typename Key, typename Value>
class LruCache {
 public:
  /// Holds values up to this total weight, and the newest one in any case.
  explicit LruCache(std::size_t capacity) : capacity_(capacity) {}

  /// The value of a key; null if it is not in the cache.
  const Value* find(const Key& key) {
    const auto found = at_key_.find(key);
    if (found == at_key_.end()) return nullptr;
    newest_first_.splice(newest_first_.begin(), newest_first_, found->second);
    return &found->second->value;
  }

  /// Adds the value of a key that is not in the cache. Values that were not used for the
  /// longest time are removed while the total weight is above the capacity.
  const Value& insert(const Key& key, Value value, std::size_t weight) {
    newest_first_.push_front({key, std::move(value), weight});
    at_key_[key] = newest_first_.begin();
    weight_ += weight;
    while (weight_ > capacity_ && newest_first_.size() > 1) evict_oldest();
    return newest_first_.front().value;
  }

  /// Removes all values.
  void clear() {
    newest_first_.clear();
    at_key_.clear();
    weight_ = 0;
  }

 private:
  struct Entry {
    Key key;
    Value value;
    std::size_t weight;
  };

  void evict_oldest() {
    weight_ -= newest_first_.back().weight;
    at_key_.erase(newest_first_.back().key);
    newest_first_.pop_back();
  }

  std::size_t capacity_;
  std::size_t weight_ = 0;
  std::list<Entry> newest_first_;
  std::map<Key, typename std::list<Entry>::iterator> at_key_;
};

}  // namespace lidar_mapping
