// The kernel of move_kernel.hpp; included by one file per instruction set, with vectors of the
// compiler's that are as wide as a register.

#include <cstdint>
#include <cstring>

#ifdef __AVX2__
#include <immintrin.h>
#endif

#include "move_kernel.hpp"

namespace lidar_mapping::preprocessing {
namespace {

#ifdef __AVX2__
constexpr std::size_t kLanes = 8;
#else
constexpr std::size_t kLanes = 4;
#endif
using Floats = float __attribute__((vector_size(kLanes * sizeof(float))));
using Ints = std::int32_t __attribute__((vector_size(kLanes * sizeof(std::int32_t))));
constexpr unsigned kAll = (1U << kLanes) - 1U;

#define LIDAR_MAPPING_INLINE inline __attribute__((always_inline))

LIDAR_MAPPING_INLINE void load(const void* from, Floats& to) { std::memcpy(&to, from, sizeof(to)); }
LIDAR_MAPPING_INLINE void store(const Floats& from, float* to) {
  std::memcpy(to, &from, sizeof(from));
}

#ifdef __AVX2__

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

/// Points k and k + 4.
LIDAR_MAPPING_INLINE void load_points(const unsigned char* from, std::size_t step, Floats& to) {
  __m128 low, high;
  std::memcpy(&low, from, sizeof(low));
  std::memcpy(&high, from + 4 * step, sizeof(high));
  to = _mm256_set_m128(high, low);
}
LIDAR_MAPPING_INLINE void store_points(const Floats& from, float* to) {
  _mm_storeu_ps(to, _mm256_castps256_ps128(from));
  _mm_storeu_ps(to + 16, _mm256_extractf128_ps(from, 1));
}

// Shuffles stay within the halves of a register, which is cheaper.
constexpr Ints kLower = {0, 8, 1, 9, 4, 12, 5, 13};
constexpr Ints kUpper = {2, 10, 3, 11, 6, 14, 7, 15};
constexpr Ints kFirst = {0, 1, 8, 9, 4, 5, 12, 13};
constexpr Ints kSecond = {2, 3, 10, 11, 6, 7, 14, 15};
constexpr Ints kThirdFrom[4] = {{0, 1, 8, 11, 4, 5, 12, 15},
                                {2, 3, 9, 11, 6, 7, 13, 15},
                                {0, 1, 10, 11, 4, 5, 14, 15},
                                {2, 3, 11, 11, 6, 7, 15, 15}};
constexpr Ints kFourth = {0, 1, 2, 11, 4, 5, 6, 15};

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
LIDAR_MAPPING_INLINE void store_points(const Floats& from, float* to) { store(from, to); }

constexpr Ints kLower = {0, 4, 1, 5};
constexpr Ints kUpper = {2, 6, 3, 7};
constexpr Ints kFirst = {0, 1, 4, 5};
constexpr Ints kSecond = {2, 3, 6, 7};
constexpr Ints kThirdFrom[4] = {{0, 1, 4, 7}, {2, 3, 5, 7}, {0, 1, 6, 7}, {2, 3, 7, 7}};
constexpr Ints kFourth = {0, 1, 2, 7};

#endif

/// Points as they lie in memory, four floats each: row k has points k, k + 4, ...
struct Rows {
  Floats row[4];
};

struct Places {
  Floats x, y, z;
};

LIDAR_MAPPING_INLINE Places places_of(const Rows& points) {
  const Floats xy0 = __builtin_shuffle(points.row[0], points.row[1], kLower);
  const Floats xy1 = __builtin_shuffle(points.row[2], points.row[3], kLower);
  const Floats zw0 = __builtin_shuffle(points.row[0], points.row[1], kUpper);
  const Floats zw1 = __builtin_shuffle(points.row[2], points.row[3], kUpper);
  return {__builtin_shuffle(xy0, xy1, kFirst), __builtin_shuffle(xy0, xy1, kSecond),
          __builtin_shuffle(zw0, zw1, kFirst)};
}

/// What the points have beside their places stays.
LIDAR_MAPPING_INLINE void put(const Places& places, Rows& points) {
  const Floats xy0 = __builtin_shuffle(places.x, places.y, kLower);
  const Floats xy1 = __builtin_shuffle(places.x, places.y, kUpper);
  for (int k = 0; k < 4; ++k) {
    const Floats xyz = __builtin_shuffle(k < 2 ? xy0 : xy1, places.z, kThirdFrom[k]);
    points.row[k] = __builtin_shuffle(xyz, points.row[k], kFourth);
  }
}

LIDAR_MAPPING_INLINE Floats moved(const float* row, const Places& p) {
  return plus(plus(plus(all(row[3]), all(row[2]), p.z), all(row[1]), p.y), all(row[0]), p.x);
}

LIDAR_MAPPING_INLINE Places moved_by(const float* place, const Places& p) {
  return {moved(place, p), moved(place + 4, p), moved(place + 8, p)};
}

/// `since`: slots since the middle of this one.
LIDAR_MAPPING_INLINE Places moved_within(const MotionSlot& slot, const Floats& since,
                                         const Places& raw) {
  const float* const w = slot.turning;
  const float* const v = slot.drift;
  const Places p = moved_by(slot.place, raw);
  const Floats dx = minus(plus(all(v[0]), all(w[1]), p.z), all(w[2]), p.y);
  const Floats dy = minus(plus(all(v[1]), all(w[2]), p.x), all(w[0]), p.z);
  const Floats dz = minus(plus(all(v[2]), all(w[0]), p.y), all(w[1]), p.x);
  return {plus(p.x, since, dx), plus(p.y, since, dy), plus(p.z, since, dz)};
}

/// A slot, and the slots from its middle to time 0.
struct Now {
  const MotionSlot* slot;
  float offset;
};

inline Now slot_at(const SlottedMotion& motion, float time) {
  const float position = (time - motion.begin) * motion.slots_per_second;
  const float last = static_cast<float>(motion.count - 1);
  // NaN becomes 0; the point is dropped.
  const int slot = position > 0.0F ? static_cast<int>(position < last ? position : last) : 0;
  return {motion.slots + slot,
          -motion.begin * motion.slots_per_second - (static_cast<float>(slot) + 0.5F)};
}

/// Slots to both sides of a slot's middle for which it may serve: at 1 rad/s and 100 m it is off by
/// 0.05 mm there.
constexpr float kReach = 1.0F;

LIDAR_MAPPING_INLINE bool in_reach(const Floats& since) {
  return bits_of((since > -kReach) & (since < kReach)) == kAll;
}

/// Each lane from a motion of all by its own slot.
__attribute__((noinline)) Places moved_each(const SlottedMotion& motion, const float* times,
                                            const Places& raw) {
  Places result{};
  for (std::size_t k = 0; k < kLanes; ++k) {
    const Now now = slot_at(motion, times[k]);
    const float since = times[k] * motion.slots_per_second + now.offset;
    const float held = since > 0.5F ? 0.5F : since > -0.5F ? since : -0.5F;
    const Places moved = moved_within(*now.slot, all(held), raw);
    result.x[k] = moved.x[k];
    result.y[k] = moved.y[k];
    result.z[k] = moved.z[k];
  }
  return result;
}

/// Neighbours in a cloud were measured shortly one after the other, so that one slot serves them
/// and those that follow; where it does not, that of a point in the middle.
LIDAR_MAPPING_INLINE Places moved_timed(const SlottedMotion& motion, const float* times, Now& now,
                                        const Places& raw) {
  Floats time;
  load(times, time);
  const auto since = [&] { return plus(all(now.offset), time, all(motion.slots_per_second)); };
  if (!in_reach(since())) now = slot_at(motion, times[kLanes / 2]);
  if (in_reach(since())) return moved_within(*now.slot, since(), raw);
  const Places copy = raw;  // its address keeps the others in memory only here
  return moved_each(motion, times, copy);
}

LIDAR_MAPPING_INLINE Ints is_inside(const KeepRule& rule, const Places& p) {
  return (p.x > rule.box_min[0]) & (p.x < rule.box_max[0]) & (p.y > rule.box_min[1]) &
         (p.y < rule.box_max[1]) & (p.z > rule.box_min[2]) & (p.z < rule.box_max[2]);
}

/// The part of a cloud that is done; where it is written over the source, it never overtakes what
/// is still to be read.
struct Done {
  float* points;
  float* times;
  std::size_t kept;
  std::size_t not_finite;
};

LIDAR_MAPPING_INLINE void store_all(const Rows& points, float* to) {
  for (int k = 0; k < 4; ++k) store_points(points.row[k], to + 4 * k);
}

/// Those of the points that stay.
template <bool keeps_times>
__attribute__((noinline)) void append_some(const Rows& points, const float* times, unsigned keep,
                                           Done& done) {
  float all_points[4 * kLanes];
  store_all(points, all_points);
  for (std::size_t k = 0; k < kLanes; ++k) {
    if ((keep >> k & 1U) == 0) continue;
    std::memcpy(done.points + 4 * done.kept, all_points + 4 * k, 4 * sizeof(float));
    if constexpr (keeps_times) done.times[done.kept] = times[k];
    ++done.kept;
  }
}

/// Where the intensity does not follow the coordinates.
LIDAR_MAPPING_INLINE void put_intensities(const PointSource& source, const unsigned char* from,
                                          Rows& points) {
  for (std::size_t k = 0; k < kLanes; ++k) {
    float intensity;
    std::memcpy(&intensity, from + k * source.step + source.intensity, sizeof(intensity));
    points.row[k % 4][4 * (k / 4) + 3] = intensity;
  }
}

/// The points of the source from number `first` on, as many as there are lanes.
template <bool has_times, bool keeps_times>
LIDAR_MAPPING_INLINE void move_some(const PointSource& source, std::size_t first,
                                    const KeepRule& rule, const SlottedMotion& motion, Now& now,
                                    Done& done) {
  const unsigned char* const from = source.first + first * source.step;
  const float* const times = has_times ? source.times + first : nullptr;
  Rows points;
  for (std::size_t k = 0; k < 4; ++k) {
    load_points(from + k * source.step, source.step, points.row[k]);
  }
  Places p = places_of(points);
  Floats range = plus(plus(p.z * p.z, p.y, p.y), p.x, p.x);
  if constexpr (has_times) {
    Floats time;
    load(times, time);
    range = plus(range, time, Floats{});  // a time that is not finite makes no number of it
    p = moved_timed(motion, times, now, p);
  } else {
    p = moved_by(motion.slots->place, p);
  }
  Ints keep = (range >= rule.near_squared) & (range <= rule.far_squared);  // NaN fails
  if (rule.has_box) keep &= ~is_inside(rule, p);
  if (source.intensity != 3 * sizeof(float)) put_intensities(source, from, points);
  put(p, points);
  const unsigned bits = bits_of(keep);
  if (bits == kAll) {
    store_all(points, done.points + 4 * done.kept);
    if constexpr (keeps_times) std::memmove(done.times + done.kept, times, sizeof(Floats));
    done.kept += kLanes;
    return;
  }
  const unsigned finite = bits_of((range - range) == 0.0F);
  for (std::size_t k = 0; k < kLanes; ++k) done.not_finite += (finite >> k & 1U) == 0 ? 1 : 0;
  const Rows copy = points;
  append_some<keeps_times>(copy, times, bits, done);
}

/// The last points of a source, filled up with points at the sensor itself, which are dropped.
template <bool has_times, bool keeps_times>
void move_rest(const PointSource& source, std::size_t first, const KeepRule& rule,
               const SlottedMotion& motion, Done& done) {
  constexpr std::size_t kCoordinates = 3 * sizeof(float), kPoint = 4 * sizeof(float);
  unsigned char rest[kLanes * kPoint] = {};
  float times[kLanes] = {};
  for (std::size_t k = 0; first + k < source.count; ++k) {
    const unsigned char* const from = source.first + (first + k) * source.step;
    std::memcpy(rest + k * kPoint, from, kCoordinates);
    std::memcpy(rest + k * kPoint + kCoordinates, from + source.intensity, sizeof(float));
    if constexpr (has_times) times[k] = source.times[first + k];
  }
  Now now = slot_at(motion, times[0]);
  move_some<has_times, keeps_times>({rest, kPoint, kCoordinates, times, kLanes}, 0, rule, motion,
                                    now, done);
}

template <bool has_times, bool keeps_times>
MoveResult move_all(const PointSource& source, const PointSink& sink, const KeepRule& rule,
                    const SlottedMotion& motion) {
  Done done{sink.points, sink.times, 0, 0};
  Now now = slot_at(motion, motion.begin);
  const std::size_t whole = source.count - source.count % kLanes;
  for (std::size_t i = 0; i < whole; i += kLanes) {
    move_some<has_times, keeps_times>(source, i, rule, motion, now, done);
  }
  if (whole < source.count) {
    move_rest<has_times, keeps_times>(source, whole, rule, motion, done);
  }
  return {done.kept, done.not_finite};
}

MoveResult move_points(const PointSource& source, const PointSink& sink, const KeepRule& rule,
                       const SlottedMotion& motion, bool keeps_times) {
  if (source.times == nullptr) return move_all<false, false>(source, sink, rule, motion);
  return keeps_times ? move_all<true, true>(source, sink, rule, motion)
                     : move_all<true, false>(source, sink, rule, motion);
}

}  // namespace
}  // namespace lidar_mapping::preprocessing
