// SPDX-License-Identifier: BSD-3-Clause
#include "bags/cdr_message.hpp"

#include <cstring>
#include <utility>

#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/number_bytes.hpp"

namespace lidar_mapping::ros_border {

namespace {

using Kind = MessageField::Kind;
using Count = MessageField::Count;
using Fields = std::vector<MessageField>;

constexpr std::size_t kLength = sizeof(std::uint32_t);  // bytes of a count, by CDR and by ROS 1
constexpr std::size_t kHead = 4;           // bytes before the data, by CDR's encapsulation
constexpr std::uint8_t kLittleEndian = 1;  // second byte of the head, by CDR's encapsulation

/// How data of Zstandard begin, by its format (RFC 8878).
constexpr std::uint8_t kZstandard[] = {0x28, 0xB5, 0x2F, 0xFD};

/// Writes what it reads.
class Transcoder {
 public:
  Transcoder(ByteRange data, const MessageLayout& layout) : data_(data), layout_(layout) {
    out_.reserve(data.size + kLength);  // header.seq
  }

  std::vector<std::uint8_t> run() {
    copy(layout_.fields);
    return std::move(out_);
  }

 private:
  void copy(const Fields& fields) {
    for (const MessageField& field : fields) {
      std::size_t count = field.count == Count::kFixed ? field.elements : 1;
      if (field.count == Count::kAny) count = copy_length();
      copy_elements(field, count);
    }
  }

  void copy_elements(const MessageField& field, std::size_t count) {
    if (count == 0) return;
    if (field.kind == Kind::kNumber) return copy_numbers(field.size, count);
    // Each element needs at least a byte, so that a damaged count ends soon.
    if (count > data_.size - at_) fail();
    for (std::size_t i = 0; i < count; ++i) copy_element(field);
  }

  void copy_element(const MessageField& field) {
    switch (field.kind) {
      case Kind::kNumber:
        return copy_numbers(field.size, 1);
      case Kind::kTime:
        return copy_numbers(kLength, 2);
      case Kind::kText:
        return copy_text();
      case Kind::kSequenceNumber:
        return write_length(0);
      case Kind::kMessage:
        return copy(layout_.messages.at(field.type));
    }
  }

  void copy_numbers(std::size_t size, std::size_t count) {
    align(size);
    if (count > (data_.size - at_) / size) fail();
    write(data_.first + at_, count * size);
    at_ += count * size;
  }

  /// In CDR, but not in ROS 1, a text ends with a zero, which its length counts.
  void copy_text() {
    const std::size_t length = read_length();
    if (length > data_.size - at_) fail();
    const std::size_t letters = length == 0 ? 0 : length - 1;
    write_length(static_cast<std::uint32_t>(letters));
    write(data_.first + at_, letters);
    at_ += length;
  }

  std::size_t copy_length() {
    const std::uint32_t length = read_length();
    write_length(length);
    return length;
  }

  std::uint32_t read_length() {
    align(kLength);
    if (data_.size - at_ < kLength) fail();
    const auto length = number_at<std::uint32_t>(data_.first + at_);
    at_ += kLength;
    return length;
  }

  void write_length(std::uint32_t length) {
    std::uint8_t bytes[kLength];
    std::memcpy(bytes, &length, kLength);
    write(bytes, kLength);
  }

  void write(const std::uint8_t* bytes, std::size_t count) {
    out_.insert(out_.end(), bytes, bytes + count);
  }

  void align(std::size_t size) {
    at_ = (at_ + size - 1) / size * size;
    if (at_ > data_.size) fail();
  }

  [[noreturn]] static void fail() {
    throw InputError("a message is cut off: it is shorter than its counts say");
  }

  ByteRange data_;
  const MessageLayout& layout_;
  std::size_t at_ = 0;
  std::vector<std::uint8_t> out_;
};

}  // namespace

std::vector<std::uint8_t> from_cdr(ByteRange message, const MessageLayout& layout) {
  if (message.size >= sizeof kZstandard &&
      std::memcmp(message.first, kZstandard, sizeof kZstandard) == 0) {
    throw InputError("messages are compressed (zstd); ros2 bag convert decompresses them");
  }
  if (message.size < kHead || message.first[0] != 0 || message.first[1] != kLittleEndian) {
    throw InputError("a message is not serialised as little-endian CDR");
  }
  return Transcoder({message.first + kHead, message.size - kHead}, layout).run();
}

}  // namespace lidar_mapping::ros_border
