// SPDX-License-Identifier: BSD-3-Clause
// The kernel of move_kernel.hpp, included by one file per instruction set. It uses vector types of
// the compiler that are as wide as a register.

#include <cstdint>
#include <cstring>

#ifdef __AVX2__
#include <immintrin.h>
#endif

#include "lidar_mapping/common/vectorization.hpp"

#include "points/move_kernel.hpp"

namespace lidar_mapping::preprocessing {
namespace {

#if defined(__AVX512F__)
constexpr int kLanes = 16;  // floats in a register of 512 bits
#elif defined(__AVX2__)
constexpr int kLanes = 8;  // floats in a register of 256 bits
#else
constexpr int kLanes = 4;  // floats in a register of 128 bits, which every processor has
#endif
using Floats = float __attribute__((vector_size(kLanes * sizeof(float))));
using Ints = std::int32_t __attribute__((vector_size(kLanes * sizeof(std::int32_t))));
constexpr unsigned kAll = (1U << kLanes) - 1U;  // a bit per lane, by definition
/// Number of points in a register, by the layout of four floats each.
constexpr int kQuads = kLanes / 4;

#define LIDAR_MAPPING_INLINE inline __attribute__((always_inline))

LIDAR_MAPPING_INLINE void load(const void* from, Floats& to) { std::memcpy(&to, from, sizeof(to)); }
LIDAR_MAPPING_INLINE void store(const Floats& from, float* to) {
  std::memcpy(to, &from, sizeof(from));
}

#if defined(__AVX512F__)

LIDAR_MAPPING_INLINE Floats all(float value) { return _mm512_set1_ps(value); }
/// c + a b and c - a b, rounded once.
LIDAR_MAPPING_INLINE Floats plus(const Floats& c, const Floats& a, const Floats& b) {
  return _mm512_fmadd_ps(a, b, c);
}
LIDAR_MAPPING_INLINE Floats minus(const Floats& c, const Floats& a, const Floats& b) {
  return _mm512_fnmadd_ps(a, b, c);
}
/// A bit for each lane in which a comparison was true.
LIDAR_MAPPING_INLINE unsigned bits_of(const Ints& lanes) {
  return _mm512_movepi32_mask(reinterpret_cast<const __m512i&>(lanes));
}

LIDAR_MAPPING_INLINE __m256 two_points(const unsigned char* from, std::size_t step) {
  __m128 first, second;
  std::memcpy(&first, from, sizeof(first));
  std::memcpy(&second, from + step, sizeof(second));
  return _mm256_set_m128(second, first);
}
LIDAR_MAPPING_INLINE void load_points(const unsigned char* from, std::size_t step, Floats& to) {
  const __m512 low = _mm512_castps256_ps512(two_points(from, step));
  to = _mm512_insertf32x8(low, two_points(from + 2 * step, step), 1);
}

/// A mask of LIDAR_MAPPING_SHUFFLE that takes the same four values in each quad.
constexpr Ints in_each_quad(int a, int b, int c, int d) {
  return Ints{a,     b,     c,     d,     a + 4,  b + 4,  c + 4,  d + 4,
              a + 8, b + 8, c + 8, d + 8, a + 12, b + 12, c + 12, d + 12};
}
/// Number of the point in each lane of Coordinates.
constexpr Ints kPointOfLane = {0, 4, 8, 12, 1, 5, 9, 13, 2, 6, 10, 14, 3, 7, 11, 15};

#elif defined(__AVX2__)

LIDAR_MAPPING_INLINE Floats all(float value) { return _mm256_set1_ps(value); }
/// c + a b and c - a b, rounded once.
LIDAR_MAPPING_INLINE Floats plus(const Floats& c, const Floats& a, const Floats& b) {
  return _mm256_fmadd_ps(a, b, c);
}
LIDAR_MAPPING_INLINE Floats minus(const Floats& c, const Floats& a, const Floats& b) {
  return _mm256_fnmadd_ps(a, b, c);
}
/// A bit for each lane in which a comparison was true.
LIDAR_MAPPING_INLINE unsigned bits_of(const Ints& lanes) {
  return static_cast<unsigned>(_mm256_movemask_ps(reinterpret_cast<const __m256&>(lanes)));
}

LIDAR_MAPPING_INLINE void load_points(const unsigned char* from, std::size_t step, Floats& to) {
  __m128 first, second;
  std::memcpy(&first, from, sizeof(first));
  std::memcpy(&second, from + step, sizeof(second));
  to = _mm256_set_m128(second, first);
}

constexpr Ints in_each_quad(int a, int b, int c, int d) {
  return Ints{a, b, c, d, a + 4, b + 4, c + 4, d + 4};
}
constexpr Ints kPointOfLane = {0, 2, 4, 6, 1, 3, 5, 7};

#else

LIDAR_MAPPING_INLINE Floats all(float value) { return Floats{value, value, value, value}; }
LIDAR_MAPPING_INLINE Floats plus(const Floats& c, const Floats& a, const Floats& b) {
  return c + a * b;
}
LIDAR_MAPPING_INLINE Floats minus(const Floats& c, const Floats& a, const Floats& b) {
  return c - a * b;
}
LIDAR_MAPPING_INLINE unsigned bits_of(const Ints& lanes) {
  const Ints bits = lanes & Ints{1, 2, 4, 8};
  return static_cast<unsigned>(bits[0] | bits[1] | bits[2] | bits[3]);
}

LIDAR_MAPPING_INLINE void load_points(const unsigned char* from, std::size_t, Floats& to) {
  load(from, to);
}

constexpr Ints in_each_quad(int a, int b, int c, int d) { return Ints{a, b, c, d}; }
constexpr Ints kPointOfLane = {0, 1, 2, 3};

#endif

/// Points as they lie in memory, four floats each, kQuads in a row.
struct Rows {
  Floats row[4];
};

/// Lane 4 q + r has point q of row r: shuffles stay within the quads, which is cheaper.
struct Coordinates {
  Floats x, y, z;
};

// Masks for two registers a and b, by what each quad of the result holds: a0 is the first value of
// the same quad of a, and so on. In a mask, numbers from kLanes on are those of b.
/// a0 b0 a1 b1; below, a2 b2 a3 b3.
constexpr Ints kLower = in_each_quad(0, kLanes, 1, kLanes + 1);
constexpr Ints kUpper = in_each_quad(2, kLanes + 2, 3, kLanes + 3);
/// a0 a1 b0 b1; below, a2 a3 b2 b3.
constexpr Ints kFirst = in_each_quad(0, 1, kLanes, kLanes + 1);
constexpr Ints kSecond = in_each_quad(2, 3, kLanes + 2, kLanes + 3);
/// For the point of row k: two values of a (x and y), then bk (z); the fourth is replaced later.
constexpr Ints kThirdFrom[4] = {
    in_each_quad(0, 1, kLanes, kLanes + 3), in_each_quad(2, 3, kLanes + 1, kLanes + 3),
    in_each_quad(0, 1, kLanes + 2, kLanes + 3), in_each_quad(2, 3, kLanes + 3, kLanes + 3)};
/// a0 a1 a2 b3.
constexpr Ints kFourth = in_each_quad(0, 1, 2, kLanes + 3);

LIDAR_MAPPING_INLINE Coordinates coordinates_of(const Rows& points) {
  const Floats xy0 = LIDAR_MAPPING_SHUFFLE(points.row[0], points.row[1], kLower);
  const Floats xy1 = LIDAR_MAPPING_SHUFFLE(points.row[2], points.row[3], kLower);
  const Floats zw0 = LIDAR_MAPPING_SHUFFLE(points.row[0], points.row[1], kUpper);
  const Floats zw1 = LIDAR_MAPPING_SHUFFLE(points.row[2], points.row[3], kUpper);
  return {LIDAR_MAPPING_SHUFFLE(xy0, xy1, kFirst), LIDAR_MAPPING_SHUFFLE(xy0, xy1, kSecond),
          LIDAR_MAPPING_SHUFFLE(zw0, zw1, kFirst)};
}

/// The fourth value of each point is kept.
LIDAR_MAPPING_INLINE void put(const Coordinates& coordinates, Rows& points) {
  const Floats xy0 = LIDAR_MAPPING_SHUFFLE(coordinates.x, coordinates.y, kLower);
  const Floats xy1 = LIDAR_MAPPING_SHUFFLE(coordinates.x, coordinates.y, kUpper);
  for (int k = 0; k < 4; ++k) {
    const Floats xyz = LIDAR_MAPPING_SHUFFLE(k < 2 ? xy0 : xy1, coordinates.z, kThirdFrom[k]);
    points.row[k] = LIDAR_MAPPING_SHUFFLE(xyz, points.row[k], kFourth);
  }
}

LIDAR_MAPPING_INLINE Floats moved(const float* row, const Coordinates& p) {
  return plus(plus(plus(all(row[3]), all(row[2]), p.z), all(row[1]), p.y), all(row[0]), p.x);
}

LIDAR_MAPPING_INLINE Coordinates moved_by(const float* transform, const Coordinates& p) {
  return {moved(transform, p), moved(transform + 4, p), moved(transform + 8, p)};
}

/// `since`: time since the middle of this slot, in slots.
LIDAR_MAPPING_INLINE Coordinates moved_within(const MotionSlot& slot, const Floats& since,
                                              const Coordinates& raw) {
  const float* const w = slot.turning;
  const float* const v = slot.drift;
  const Coordinates p = moved_by(slot.transform, raw);
  const Floats dx = minus(plus(all(v[0]), all(w[1]), p.z), all(w[2]), p.y);
  const Floats dy = minus(plus(all(v[1]), all(w[2]), p.x), all(w[0]), p.z);
  const Floats dz = minus(plus(all(v[2]), all(w[0]), p.y), all(w[1]), p.x);
  return {plus(p.x, since, dx), plus(p.y, since, dy), plus(p.z, since, dz)};
}

/// Distance from a slot's middle, in slots of 1 ms, up to which a point may use the slot. Chosen:
/// the error of a straight motion is then at most (0.001 s * 1 rad/s)^2 / 2 * 100 m = 0.05 mm.
constexpr float kReach = 1.0F;

/// Finds the slots of a motion by time.
struct Slots {
  const MotionSlot* first;
  float rate;   ///< per second
  float start;  ///< position of the time 0, in slots since the motion's begin
  float last;   ///< number of the last slot

  int at(float position) const {
    const float from_first = position > 0.0F ? position : 0.0F;  // NaN becomes 0
    return static_cast<int>(from_first < last ? from_first : last);
  }
  int of(float time) const { return at(time * rate + start); }
};

/// Moves each lane by its own slot.
__attribute__((noinline)) Coordinates moved_each(const Slots& slots, const Floats& positions,
                                                 const Coordinates& raw) {
  Coordinates result{};
  for (int k = 0; k < kLanes; ++k) {
    const int slot = slots.at(positions[k]);
    const float since = positions[k] - (static_cast<float>(slot) + 0.5F);
    const float held = since > 0.5F ? 0.5F : since > -0.5F ? since : -0.5F;
    const Coordinates moved = moved_within(slots.first[slot], all(held), raw);
    result.x[k] = moved.x[k];
    result.y[k] = moved.y[k];
    result.z[k] = moved.z[k];
  }
  return result;
}

/// Moves all lanes by one slot, if it may be used for all.
LIDAR_MAPPING_INLINE Coordinates moved_timed(const Slots& slots, int slot, const Floats& times,
                                             const Coordinates& raw) {
  const float middle = static_cast<float>(slot) + 0.5F;
  const Floats since = plus(all(slots.start - middle), times, all(slots.rate));
  const bool in_reach = bits_of((since > -kReach) & (since < kReach)) == kAll;
  if (__builtin_expect(in_reach, true)) return moved_within(slots.first[slot], since, raw);
  // because its address is taken, the compiler keeps only this copy in memory
  const Coordinates copy = raw;
  const Floats positions = since + all(middle);
  return moved_each(slots, positions, copy);
}

/// m^2, smaller than any square, by definition: the rule keeps no point with it.
constexpr float kNeverKept = -1.0F;

/// Whether a point lies in the box where it was measured: the motion during the scan would carry
/// what rides along out of it.
LIDAR_MAPPING_INLINE Ints is_inside(const KeepRule& rule, const Coordinates& raw) {
  const Coordinates p = moved_by(rule.to_box, raw);
  return (p.x > rule.box_min[0]) & (p.x < rule.box_max[0]) & (p.y > rule.box_min[1]) &
         (p.y < rule.box_max[1]) & (p.z > rule.box_min[2]) & (p.z < rule.box_max[2]);
}

/// The part of the cloud that is finished. If it is written over the source, it never overwrites
/// points that are not read yet.
struct Done {
  float* points;
  float* times;
  std::size_t kept;
  std::size_t not_finite;
};

LIDAR_MAPPING_INLINE void store_all(const Rows& points, float* to) {
  store(points.row[0], to);
  store(points.row[1], to + kLanes);
  store(points.row[2], to + 2 * kLanes);
  store(points.row[3], to + 3 * kLanes);
}

/// Writes the points that are kept.
template <bool keeps_times>
__attribute__((noinline)) Done append_some(const Rows& points, const float* times, unsigned keep,
                                           Done done) {
  float all_points[4 * kLanes];
  store_all(points, all_points);
  for (int k = 0; k < kLanes; ++k) {
    const int lane = 4 * (k % kQuads) + k / kQuads;
    if ((keep >> lane & 1U) == 0) continue;
    std::memcpy(done.points + 4 * done.kept, all_points + 4 * k, 4 * sizeof(float));
    if constexpr (keeps_times) done.times[done.kept] = times[k];
    ++done.kept;
  }
  return done;
}

/// Sets intensities that are not finite to zero; coordinates that are not are never kept.
LIDAR_MAPPING_INLINE void clear_bad_intensities(Rows& points) {
  for (int k = 0; k < 4; ++k) {
    const Floats row = points.row[k];
    points.row[k] = (row - row) == 0.0F ? row : Floats{};
  }
}

/// Used if the intensity does not follow the coordinates.
LIDAR_MAPPING_INLINE void put_intensities(const PointSource& source, const unsigned char* from,
                                          Rows& points) {
  for (int k = 0; k < kLanes; ++k) {
    float intensity;
    std::memcpy(&intensity, from + k * source.step + source.intensity, sizeof(intensity));
    points.row[k / kQuads][4 * (k % kQuads) + 3] = intensity;
  }
}

/// Reads the points of the source from number `first` on, as many as there are lanes.
template <bool has_times, bool keeps_times>
LIDAR_MAPPING_INLINE void move_some(const PointSource& source, std::size_t first,
                                    const KeepRule& rule, const Slots& slots, int slot,
                                    Done& done) {
  const unsigned char* const from = source.first + first * source.step;
  const float* const times = has_times ? source.times + first : nullptr;
  Rows points;
  for (int k = 0; k < 4; ++k) {
    load_points(from + k * kQuads * source.step, source.step, points.row[k]);
  }
  Coordinates p = coordinates_of(points);
  Floats range = plus(plus(p.z * p.z, p.y, p.y), p.x, p.x);
  if (rule.has_box) range = is_inside(rule, p) ? all(kNeverKept) : range;
  if constexpr (has_times) {
    Floats time;
    load(times, time);
    time = LIDAR_MAPPING_SHUFFLE(time, kPointOfLane);
    range = plus(range, time, Floats{});  // becomes NaN if the time is not finite
    p = moved_timed(slots, slot, time, p);
  } else {
    p = moved_by(slots.first->transform, p);
  }
  const Ints keep = (range >= rule.near_squared) & (range <= rule.far_squared);  // NaN fails
  if (source.intensity != 3 * sizeof(float)) put_intensities(source, from, points);
  clear_bad_intensities(points);
  put(p, points);
  const unsigned bits = bits_of(keep);
  if (bits == kAll) {
    store_all(points, done.points + 4 * done.kept);
    if constexpr (keeps_times) std::memmove(done.times + done.kept, times, sizeof(Floats));
    done.kept += kLanes;
    return;
  }
  const unsigned finite = bits_of((range - range) == 0.0F);
  for (int k = 0; k < kLanes; ++k) done.not_finite += (finite >> k & 1U) == 0 ? 1 : 0;
  const Rows copy = points;
  done = append_some<keeps_times>(copy, times, bits, done);
}

/// The last points of a source, padded with points at the sensor itself, which are dropped.
template <bool has_times, bool keeps_times>
void move_rest(const PointSource& source, std::size_t first, const KeepRule& rule,
               const Slots& slots, Done& done) {
  // Bytes of x, y, z, and of these with the intensity, by the layout of usual drivers.
  constexpr std::size_t kCoordinates = 3 * sizeof(float), kPoint = 4 * sizeof(float);
  unsigned char rest[kLanes * kPoint] = {};
  float times[kLanes] = {};
  for (std::size_t k = 0; first + k < source.count; ++k) {
    const unsigned char* const from = source.first + (first + k) * source.step;
    std::memcpy(rest + k * kPoint, from, kCoordinates);
    std::memcpy(rest + k * kPoint + kCoordinates, from + source.intensity, sizeof(float));
    if constexpr (has_times) times[k] = source.times[first + k];
  }
  move_some<has_times, keeps_times>({rest, kPoint, kCoordinates, times, kLanes}, 0, rule, slots,
                                    slots.of(times[0]), done);
}

/// Neighbouring points in a cloud were measured at nearly the same time, so the slot of the middle
/// one can be used for a block of them. It is determined while the previous block is moved: so
/// nothing waits for it, and no branch depends on it.
template <bool has_times, bool keeps_times>
MoveResult move_all(const PointSource& given_source, const PointSink& sink,
                    const KeepRule& given_rule, const Slots& given_slots) {
  // Local copies, so that the compiler knows that no write changes them.
  const PointSource source = given_source;
  const KeepRule rule = given_rule;
  const Slots slots = given_slots;
  Done done{sink.points, sink.times, 0, 0};
  const auto slot_for = [&](std::size_t first) {
    const std::size_t middle = first + kLanes / 2;
    return has_times && middle < source.count ? slots.of(source.times[middle]) : 0;
  };
  const std::size_t whole = source.count - source.count % kLanes;
  int slot = slot_for(0);
  for (std::size_t i = 0; i < whole; i += kLanes) {
    const int next = slot_for(i + kLanes);
    move_some<has_times, keeps_times>(source, i, rule, slots, slot, done);
    slot = next;
  }
  if (whole < source.count) {
    move_rest<has_times, keeps_times>(source, whole, rule, slots, done);
  }
  return {done.kept, done.not_finite};
}

MoveResult move_points(const PointSource& source, const PointSink& sink, const KeepRule& rule,
                       const SlottedMotion& motion, bool keeps_times) {
  const Slots slots{motion.slots, motion.slots_per_second, -motion.begin * motion.slots_per_second,
                    static_cast<float>(motion.count - 1)};
  if (source.times == nullptr) return move_all<false, false>(source, sink, rule, slots);
  return keeps_times ? move_all<true, true>(source, sink, rule, slots)
                     : move_all<true, false>(source, sink, rule, slots);
}

}  // namespace
}  // namespace lidar_mapping::preprocessing
