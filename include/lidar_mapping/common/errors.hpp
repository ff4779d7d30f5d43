// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <stdexcept>

namespace lidar_mapping {

/// Base of all errors that this package throws. what() names what, value and remedy in one line.
class Error : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// A configuration that cannot be used; one line per problem.
class ConfigError : public Error {
  using Error::Error;
};

/// A caller broke the contract of a stage, for instance with stamps that go back.
class InputError : public Error {
  using Error::Error;
};

/// A file or folder that cannot be read or written.
class FileError : public Error {
  using Error::Error;
};

}  // namespace lidar_mapping
