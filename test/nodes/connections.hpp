// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace lidar_mapping::test {

/// True if the topic has one publisher and this has a connection to every node that subscribes, as
/// both ends say themselves: on a busy machine these come long after the master knows both, and
/// what is sent before is lost. A node that was killed does not answer, so its links do not count.
bool is_connected(const std::string& topic);

/// Process id of a node, as it says itself; 0 if it does not answer.
int process_of(const std::string& node);

}  // namespace lidar_mapping::test
