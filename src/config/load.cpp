// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/config/load.hpp"

#include <algorithm>
#include <numeric>

namespace lidar_mapping::config {

namespace {

/// Levenshtein distance.
std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i + 1;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t substitution = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({row[j] + 1, row[j + 1] + 1, substitution});
    }
  }
  return row.back();
}

/// Empty if no name is near enough to be a slip of the pen.
std::string nearest_name(const std::string& key, const std::vector<FieldDescription>& known) {
  std::string nearest;
  std::size_t least = key.size() / 3 + 2;
  for (const FieldDescription& field : known) {
    const std::size_t distance = edit_distance(key, field.name);
    if (distance >= least) continue;
    least = distance;
    nearest = field.name;
  }
  return nearest;
}

std::string group_of(const std::string& name) {
  const std::size_t slash = name.rfind('/');
  return slash == std::string::npos ? "" : name.substr(0, slash);
}

std::string leaf_of(const std::string& name) {
  const std::size_t slash = name.rfind('/');
  return slash == std::string::npos ? name : name.substr(slash + 1);
}

}  // namespace

std::string unknown_key_problem(const std::string& key, const Value& value,
                                const std::vector<FieldDescription>& known,
                                const std::string& origin) {
  const std::string nearest = nearest_name(key, known);
  return origin + ": unknown key '" + key + "' (value " + to_string(value) + ")" +
         (nearest.empty() ? "" : "; did you mean '" + nearest + "'?");
}

std::string twice_given_problem(const std::string& first, const std::string& second,
                                const std::string& origin) {
  return origin + ": '" + first + "' and '" + second +
         "' are names of the same parameter; remove one of them";
}

std::string bad_value_problem(const FieldDescription& field, const Value& value,
                              const std::string& problem, const std::string& origin) {
  return origin + ": " + field.name + ": " + to_string(value) + " " + problem +
         "; allowed: " + field.allowed + (field.unit.empty() ? "" : " (" + field.unit + ")");
}

std::string yaml_document(const std::string& summary, const std::vector<FieldDescription>& fields,
                          const std::vector<std::string>& values) {
  std::string text = "# " + summary + "\n";
  std::string group;
  for (std::size_t i = 0; i < fields.size(); ++i) {
    const FieldDescription& field = fields[i];
    if (group_of(field.name) != group) {
      group = group_of(field.name);
      if (!group.empty()) text += "\n" + group + ":\n";
    }
    const std::string indent = group.empty() ? "" : "  ";
    text += "\n" + indent + "# " + field.meaning + "\n" + indent + "# " + field.allowed +
            (field.unit.empty() ? "" : ", " + field.unit) + "; default " + field.default_value +
            "\n" + indent + leaf_of(field.name) + ": " + values[i] + "\n";
  }
  return text;
}

std::string markdown_table(const std::vector<FieldDescription>& fields) {
  std::string text = "| parameter | default | allowed | unit | meaning |\n|---|---|---|---|---|\n";
  for (const FieldDescription& field : fields) {
    text += "| `" + field.name + "` | `" + field.default_value + "` | " + field.allowed + " | " +
            field.unit + " | " + field.meaning + " |\n";
  }
  return text;
}

}  // namespace lidar_mapping::config
