// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

namespace lidar_mapping::ros_border {

/// Memory for chunks of a bag, which is reused when the last pointer to a chunk is gone, because
/// fresh pages would cost as much time as copying. Any thread may release it.
class ChunkMemory {
 public:
  /// Memory of at least this number of bytes, with any content; released with the last copy of the
  /// pointer.
  std::shared_ptr<std::uint8_t> take(std::size_t bytes) {
    std::unique_ptr<Block> block = state_->spare();
    if (!block) block = std::make_unique<Block>();
    if (block->size < bytes)
      *block = {std::unique_ptr<std::uint8_t[]>(new std::uint8_t[bytes]), bytes};
    std::uint8_t* const first = block->bytes.get();
    return {first, [state = state_, kept = block.release()](std::uint8_t*) { state->give(kept); }};
  }

 private:
  struct Block {
    std::unique_ptr<std::uint8_t[]> bytes;
    std::size_t size = 0;
  };
  class State {
   public:
    std::unique_ptr<Block> spare() {
      const std::lock_guard<std::mutex> lock(mutex_);
      if (blocks_.empty()) return nullptr;
      std::unique_ptr<Block> block = std::move(blocks_.back());
      blocks_.pop_back();
      return block;
    }
    void give(Block* block) {
      const std::lock_guard<std::mutex> lock(mutex_);
      blocks_.emplace_back(block);
    }

   private:
    std::mutex mutex_;
    std::vector<std::unique_ptr<Block>> blocks_;
  };

  std::shared_ptr<State> state_ = std::make_shared<State>();
};

}  // namespace lidar_mapping::ros_border
