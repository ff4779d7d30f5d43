// The kernel of move_kernel.hpp; included by one file per instruction set.
// Eight points at a time as the compiler's vectors: on plain x86-64 each becomes two SSE registers.

#include <cstdint>
#include <cstring>

#ifdef __AVX2__
#include <immintrin.h>
#endif

#include "move_kernel.hpp"

namespace lidar_mapping::preprocessing {
namespace {

constexpr std::size_t kLanes = 8;
using Floats = float __attribute__((vector_size(kLanes * sizeof(float))));
using Ints = std::int32_t __attribute__((vector_size(kLanes * sizeof(std::int32_t))));

#define LIDAR_MAPPING_INLINE inline __attribute__((always_inline))

/// Where a point's lane is: shuffles that stay within halves of a register are cheaper.
constexpr std::size_t kLaneOf[kLanes] = {0, 4, 1, 5, 2, 6, 3, 7};

/// Between eight points, two in a vector, and their coordinates x y z w; its own inverse.
LIDAR_MAPPING_INLINE void transpose(Floats& a, Floats& b, Floats& c, Floats& d) {
  constexpr Ints kLower = {0, 8, 1, 9, 4, 12, 5, 13};
  constexpr Ints kUpper = {2, 10, 3, 11, 6, 14, 7, 15};
  constexpr Ints kFirst = {0, 1, 8, 9, 4, 5, 12, 13};
  constexpr Ints kSecond = {2, 3, 10, 11, 6, 7, 14, 15};
  const Floats xy0 = __builtin_shuffle(a, b, kLower);
  const Floats xy1 = __builtin_shuffle(c, d, kLower);
  const Floats zw0 = __builtin_shuffle(a, b, kUpper);
  const Floats zw1 = __builtin_shuffle(c, d, kUpper);
  a = __builtin_shuffle(xy0, xy1, kFirst);
  b = __builtin_shuffle(xy0, xy1, kSecond);
  c = __builtin_shuffle(zw0, zw1, kFirst);
  d = __builtin_shuffle(zw0, zw1, kSecond);
}

LIDAR_MAPPING_INLINE void load(const float* from, Floats& to) {
  std::memcpy(&to, from, sizeof(to));
}

/// Two points, of which the second begins `step` bytes after the first.
LIDAR_MAPPING_INLINE void load_two(const unsigned char* from, std::size_t step, Floats& to) {
#ifdef __AVX2__
  __m128 first, second;
  std::memcpy(&first, from, sizeof(first));
  std::memcpy(&second, from + step, sizeof(second));
  const __m256 two = _mm256_set_m128(second, first);
  std::memcpy(&to, &two, sizeof(to));
#else
  float two[kLanes];
  std::memcpy(two, from, sizeof(two) / 2);
  std::memcpy(two + kLanes / 2, from + step, sizeof(two) / 2);
  load(two, to);
#endif
}
LIDAR_MAPPING_INLINE void store(const Floats& from, float* to) {
  std::memcpy(to, &from, sizeof(from));
}

/// Lanes are -1 in all bits where a comparison was true.
LIDAR_MAPPING_INLINE bool all_of(const Ints& lanes) {
#ifdef __AVX2__
  return _mm256_movemask_ps(reinterpret_cast<const __m256&>(lanes)) == 0xFF;
#else
  std::uint64_t words[kLanes / 2];
  std::memcpy(words, &lanes, sizeof(words));
  return (words[0] & words[1] & words[2] & words[3]) == ~std::uint64_t{0};
#endif
}

/// One coordinate after the motion of which `row` is the row.
LIDAR_MAPPING_INLINE void moved(const float* row, const Floats& x, const Floats& y, const Floats& z,
                                Floats& out) {
  out = row[0] * x + row[1] * y + row[2] * z + row[3];
}

LIDAR_MAPPING_INLINE void move_by(const float* place, Floats& x, Floats& y, Floats& z) {
  Floats px, py, pz;
  moved(place, x, y, z, px);
  moved(place + 4, x, y, z, py);
  moved(place + 8, x, y, z, pz);
  x = px;
  y = py;
  z = pz;
}

/// `since`: slots since the begin of this one.
LIDAR_MAPPING_INLINE void move_within(const MotionSlot& slot, const Floats& since, Floats& x,
                                      Floats& y, Floats& z) {
  Floats dx = x, dy = y, dz = z;
  move_by(slot.change, dx, dy, dz);
  move_by(slot.place, x, y, z);
  x += since * dx;
  y += since * dy;
  z += since * dz;
}

struct EightPoints {
  Floats x, y, z;
};

/// Each lane from a motion of all by its own slot. Not inlined: its copies in memory would cost the
/// usual case time.
__attribute__((noinline)) void move_each(const SlottedMotion& motion, const Floats& position,
                                         EightPoints& points) {
  Ints slots = __builtin_convertvector(position, Ints);
  slots += position == static_cast<float>(motion.count);  // -1 where true
  const Floats since = position - __builtin_convertvector(slots, Floats);
  const EightPoints before = points;
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    EightPoints all = before;
    move_within(motion.slots[slots[lane]], since, all.x, all.y, all.z);
    points.x[lane] = all.x[lane];
    points.y[lane] = all.y[lane];
    points.z[lane] = all.z[lane];
  }
}

/// Slots by which a slot's straight line may be followed beyond its ends: there the error is five
/// times that in its middle.
constexpr float kBeyond = 0.75F;

/// Where in the motion eight times lie.
struct Places {
  Floats times;
  Floats position;         ///< slots since the motion's begin, within the motion
  const MotionSlot* slot;  ///< of a lane in the middle
};

/// Called for the next points while these are moved, so that nothing waits for the slot's address.
LIDAR_MAPPING_INLINE void find_places(const SlottedMotion& motion, const float* times,
                                      Places& places) {
  constexpr Ints kToLanes = {0, 2, 4, 6, 1, 3, 5, 7};
  constexpr int kMiddle = 2;
  Floats in_order;
  load(times, in_order);
  places.times = __builtin_shuffle(in_order, kToLanes);
  const Floats last = Floats{} + static_cast<float>(motion.count);
  Floats position = (places.times - motion.begin) * motion.slots_per_second;
  position = position > 0.0F ? position : Floats{};  // NaN becomes 0; the point is dropped
  places.position = position < last ? position : last;
  const int slot = static_cast<int>(places.position[kMiddle]);
  places.slot = motion.slots + (slot < motion.count ? slot : motion.count - 1);
}

/// Neighbours in a cloud were measured shortly one after the other, so that one slot serves all;
/// where they were not, each lane is taken from a motion of all by its own slot.
LIDAR_MAPPING_INLINE void move_timed(const SlottedMotion& motion, const Places& places, Floats& x,
                                     Floats& y, Floats& z) {
  const Floats since = places.position - static_cast<float>(places.slot - motion.slots);
  if (all_of((since >= -kBeyond) & (since <= 1.0F + kBeyond))) {
    move_within(*places.slot, since, x, y, z);
    return;
  }
  EightPoints points{x, y, z};
  move_each(motion, places.position, points);
  x = points.x;
  y = points.y;
  z = points.z;
}

LIDAR_MAPPING_INLINE void is_inside(const KeepRule& rule, const Floats& x, const Floats& y,
                                    const Floats& z, Ints& inside) {
  inside = (x > rule.box_min[0]) & (x < rule.box_max[0]) & (y > rule.box_min[1]) &
           (y < rule.box_max[1]) & (z > rule.box_min[2]) & (z < rule.box_max[2]);
}

/// The part of a cloud that is done; where it is written over the source, it never overtakes what
/// is still to be read.
struct Done {
  float* points;
  float* times;
  std::size_t kept;
  std::size_t not_finite;
};

/// Those of eight points that stay.
template <bool keeps_times>
void append_some(const float* points, const float* times, const std::int32_t* keep, Done& done) {
  for (std::size_t k = 0; k < kLanes; ++k) {
    if (keep[kLaneOf[k]] == 0) continue;
    std::memcpy(done.points + 4 * done.kept, points + 4 * k, 4 * sizeof(float));
    if constexpr (keeps_times) done.times[done.kept] = times[k];
    ++done.kept;
  }
}

/// Where the intensity does not follow the coordinates.
LIDAR_MAPPING_INLINE void load_intensities(const PointSource& source, const unsigned char* from,
                                           Floats& to) {
  for (std::size_t k = 0; k < kLanes; ++k) {
    float intensity;
    std::memcpy(&intensity, from + k * source.step + source.intensity, sizeof(intensity));
    to[kLaneOf[k]] = intensity;
  }
}

/// The eight points of the source from number `first` on, whose times lie at these places.
template <bool has_times, bool keeps_times>
LIDAR_MAPPING_INLINE void move_eight(const PointSource& source, std::size_t first,
                                     const Places& places, const KeepRule& rule,
                                     const SlottedMotion& motion, Done& done) {
  const unsigned char* const from = source.first + first * source.step;
  Floats x, y, z, intensity, time{}, time_in_order{};
  load_two(from, source.step, x);
  load_two(from + 2 * source.step, source.step, y);
  load_two(from + 4 * source.step, source.step, z);
  load_two(from + 6 * source.step, source.step, intensity);
  transpose(x, y, z, intensity);
  if (source.intensity != 3 * sizeof(float)) load_intensities(source, from, intensity);
  const Floats range = x * x + y * y + z * z;
  // Written so that NaN fails.
  Ints keep = (range >= rule.near_squared) & (range <= rule.far_squared);
  if constexpr (has_times) {
    load(source.times + first, time_in_order);
    time = places.times;
    keep &= (time - time) == 0.0F;
    move_timed(motion, places, x, y, z);
  } else {
    move_by(motion.slots->place, x, y, z);
  }
  if (rule.has_box) {
    Ints inside;
    is_inside(rule, x, y, z, inside);
    keep &= ~inside;
  }
  transpose(x, y, z, intensity);
  const bool all = all_of(keep);
  float some[4 * kLanes];
  float* const out = all ? done.points + 4 * done.kept : some;
  store(x, out);
  store(y, out + 8);
  store(z, out + 16);
  store(intensity, out + 24);
  if (all) {
    if constexpr (keeps_times) store(time_in_order, done.times + done.kept);
    done.kept += kLanes;
    return;
  }
  float some_times[kLanes];
  std::int32_t kept_lanes[kLanes];
  store(time_in_order, some_times);
  std::memcpy(kept_lanes, &keep, sizeof(kept_lanes));
  append_some<keeps_times>(some, some_times, kept_lanes, done);
  const Floats sum = range + time;
  const Ints finite = (sum - sum) == 0.0F;
  for (std::size_t lane = 0; lane < kLanes; ++lane) done.not_finite += finite[lane] == 0 ? 1 : 0;
}

/// The last points of a source, less than eight, filled up with points at the sensor itself, which
/// are dropped.
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
  Places places{};
  if constexpr (has_times) find_places(motion, times, places);
  move_eight<has_times, keeps_times>({rest, kPoint, kCoordinates, times, kLanes}, 0, places, rule,
                                     motion, done);
}

template <bool has_times, bool keeps_times>
MoveResult move_all(const PointSource& source, const PointSink& sink, const KeepRule& rule,
                    const SlottedMotion& motion) {
  Done done{sink.points, sink.times, 0, 0};
  const std::size_t whole = source.count - source.count % kLanes;
  Places places{}, next{};
  if (has_times && whole > 0) find_places(motion, source.times, next);
  for (std::size_t i = 0; i < whole; i += kLanes) {
    places = next;
    if (has_times && i + kLanes < whole) find_places(motion, source.times + i + kLanes, next);
    move_eight<has_times, keeps_times>(source, i, places, rule, motion, done);
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
