// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

namespace lidar_mapping {

/// A list of elements in the order in which they were added, found by their keys. The elements lie
/// without gaps in a vector; a hash table of their positions, with linear probing and at most half
/// full, finds them. So a search that finds an element touches two cache lines, the list is walked
/// without gaps, and its order depends neither on the hash nor on the size of the table.
///
/// `Element` has a member `key` and can be made without arguments; `Hash` maps a key to a number
/// whose lower 32 bits are well mixed.
template <typename Element, typename Hash>
class KeyedList {
 public:
  /// By which an element is found.
  using Key = decltype(Element::key);

  /// An empty list. It takes `elements` without growing its table.
  explicit KeyedList(std::size_t elements = 0) {
    if (elements > 0) rebuild(slots_for(elements));
  }
  /// The list of `elements`, in their order. Their keys have to differ.
  explicit KeyedList(std::vector<Element> elements) : elements_(std::move(elements)) {
    rebuild(slots_for(elements_.size()));
  }

  /// Number of elements.
  std::size_t size() const { return elements_.size(); }
  /// All elements, in the order in which they were added.
  const std::vector<Element>& elements() const { return elements_; }
  /// Number of elements for which memory is allocated.
  std::size_t capacity() const { return elements_.capacity(); }
  /// Allocates memory for that many elements.
  void reserve(std::size_t elements) { elements_.reserve(elements); }
  /// Removes all elements and keeps the memory.
  void clear() {
    elements_.clear();
    std::fill(slots_.begin(), slots_.end(), kFree);
  }

  /// The element of that key. If there was none it is added: made without arguments, with the key.
  /// The reference is valid until the next element is added.
  Element& find_or_add(const Key& key) {
    if (2 * (elements_.size() + 1) > slots_.size()) rebuild(slots_for(elements_.size() + 1));
    std::uint32_t& slot = slots_[slot_of(key)];
    if (slot == kFree) {
      slot = static_cast<std::uint32_t>(elements_.size());
      elements_.emplace_back();
      elements_.back().key = key;
    }
    return elements_[slot];
  }

  /// Asks the processor to fetch where the search for `key` starts.
  void prefetch_slot(const Key& key) const {
    if (!slots_.empty()) __builtin_prefetch(&slots_[first_slot_of(key)]);
  }
  /// Asks the processor to fetch the element at which the search for `key` starts.
  void prefetch_element(const Key& key) const {
    if (slots_.empty()) return;
    const std::uint32_t position = slots_[first_slot_of(key)];
    if (position == kFree) return;
    const auto* const bytes = reinterpret_cast<const char*>(&elements_[position]);
    __builtin_prefetch(bytes);
    __builtin_prefetch(bytes + sizeof(Element) - 1);  // it may reach into the next cache line
  }

 private:
  static constexpr std::uint32_t kFree = 0xFFFFFFFFU;  // chosen: no position in any list
  static constexpr std::size_t kMinSlots = 1024;       // 4 kB; chosen, it doubles when needed

  static std::size_t slots_for(std::size_t elements) {
    std::size_t slots = kMinSlots;
    while (slots < 2 * elements) slots *= 2;
    return slots;
  }

  void rebuild(std::size_t slots) {
    slots_.assign(slots, kFree);
    for (std::size_t i = 0; i < elements_.size(); ++i) {
      slots_[slot_of(elements_[i].key)] = static_cast<std::uint32_t>(i);
    }
  }

  std::size_t first_slot_of(const Key& key) const { return Hash()(key) & (slots_.size() - 1); }

  /// The slot with the position of the key's element, or the free slot for it.
  std::size_t slot_of(const Key& key) const {
    const std::size_t mask = slots_.size() - 1;
    std::size_t slot = first_slot_of(key);
    while (slots_[slot] != kFree && !(elements_[slots_[slot]].key == key)) slot = (slot + 1) & mask;
    return slot;
  }

  std::vector<Element> elements_;
  std::vector<std::uint32_t> slots_;  // positions in elements_; a power of two, or none
};

}  // namespace lidar_mapping
