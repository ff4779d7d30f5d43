// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <iterator>
#include <list>
#include <map>
#include <utility>

namespace lidar_mapping {

/// A least-recently-used cache of values by their keys, limited by their total weight.
template <typename Key, typename Value>
class LruCache {
 public:
  /// `capacity`: greatest total weight.
  explicit LruCache(std::size_t capacity) : capacity_(capacity) {}

  /// The value of a key; null if it is not in the cache.
  const Value* find(const Key& key) {
    const auto found = at_key_.find(key);
    if (found == at_key_.end()) return nullptr;
    newest_first_.splice(newest_first_.begin(), newest_first_, found->second);
    return &found->second->value;
  }
  /// The same, which does not count as a use.
  const Value* peek(const Key& key) const {
    const auto found = at_key_.find(key);
    return found == at_key_.end() ? nullptr : &found->second->value;
  }

  /// Sets the value of a key. Values that were not used for the longest time are removed
  /// while the total weight is above the capacity.
  void insert(const Key& key, Value value, std::size_t weight) {
    if (const auto known = at_key_.find(key); known != at_key_.end()) remove(known->second);
    newest_first_.push_front({key, std::move(value), weight});
    at_key_[key] = newest_first_.begin();
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
    at_key_.clear();
    weight_ = 0;
  }

 private:
  struct Entry {
    Key key;
    Value value;
    std::size_t weight;
  };
  using Position = typename std::list<Entry>::iterator;

  void remove(Position entry) {
    weight_ -= entry->weight;
    at_key_.erase(entry->key);
    newest_first_.erase(entry);
  }

  std::size_t capacity_;
  std::size_t weight_ = 0;
  std::list<Entry> newest_first_;
  std::map<Key, Position> at_key_;
};

}  // namespace lidar_mapping
