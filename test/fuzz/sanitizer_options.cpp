// SPDX-License-Identifier: BSD-3-Clause
// Leaks of ROS's static objects are none of this package's; who asks for more memory than there is
// gets std::bad_alloc, as without the sanitizer.
extern "C" const char* __asan_default_options();
extern "C" const char* __asan_default_options() {
  return "detect_leaks=0:detect_odr_violation=0:allocator_may_return_null=1";
}
