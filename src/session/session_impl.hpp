// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "lidar_mapping/session/session.hpp"

#include "database.hpp"
#include "rows.hpp"
#include "session_folder.hpp"

namespace lidar_mapping::session {

/// Name of the property whether the newest stored poses lie in East-North-Up.
constexpr const char* kInEnu = "poses_in_enu";

class Session::Impl {
 public:
  Impl(std::filesystem::path directory_path, Database::Mode mode)
      : directory(std::move(directory_path)),
        lock(mode == Database::Mode::kRead ? nullptr : std::make_unique<WriteLock>(directory)),
        database(directory / "session.db", mode),
        clouds(directory / "key_frames") {}

  /// `verb` is INSERT, optionally with a rule for existing rows such as OR REPLACE.
  void insert(const std::string& verb, const std::string& table, const Cells& cells) {
    std::string places = "?";
    for (std::size_t i = 1; i < cells.size(); ++i) places += ", ?";
    database.run(verb + " INTO " + table + " VALUES (" + places + ")", cells);
  }

  template <typename Value>
  std::vector<Value> all(const std::string& sql) const {
    std::vector<Value> values;
    for (Statement row = database.query(sql); row.step();) values.push_back(from_row<Value>(row));
    return values;
  }

  const std::filesystem::path directory;
  const std::unique_ptr<WriteLock> lock;
  Database database;
  CloudStore clouds;
  std::optional<std::uint32_t> newest_drive;  ///< of the odometry; empty until it is needed
};

}  // namespace lidar_mapping::session
