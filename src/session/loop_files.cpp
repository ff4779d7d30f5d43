// SPDX-License-Identifier: BSD-3-Clause
#include "lidar_mapping/session/loop_files.hpp"

#include <cmath>
#include <iomanip>
#include <map>
#include <sstream>

#include "lidar_mapping/common/atomic_file.hpp"
#include "lidar_mapping/common/errors.hpp"
#include "lidar_mapping/common/input_file.hpp"
#include "lidar_mapping/common/number_words.hpp"
#include "lidar_mapping/common/rotations.hpp"
#include "lidar_mapping/common/text.hpp"

namespace lidar_mapping::session {

namespace {

constexpr const char* kListHead =
    "# Loops of the session. Edit a copy, then: optimize_session SESSION --loops FILE\n"
    "#   auto   FROM TO   the graph decides whether the loop is used\n"
    "#   accept FROM TO   the loop is always used\n"
    "#   refuse FROM TO   the loop is never used\n"
    "#   add    FROM TO [X Y Z [ROLL PITCH YAW]]   the two are matched from this initial guess\n"
    "#          (m, degrees), and the new loop is always used\n";

using Verdicts = std::map<std::pair<KeyFrameIndex, KeyFrameIndex>, LoopVerdict>;

/// False for a later verdict of the graph, which has no figures of a match.
bool has_figures(const LoopVerdict& verdict) {
  return verdict.horizontal_eigenvalue > 0.0 || verdict.innovation > 0.0;
}

/// Every candidate once in the order of storage, with the figures of its match and its final
/// verdict.
std::vector<LoopVerdict> candidates(const Session& session) {
  std::vector<LoopVerdict> result;
  std::map<std::pair<KeyFrameIndex, KeyFrameIndex>, std::size_t> known;
  for (const LoopVerdict& verdict : session.verdicts()) {
    const auto [entry, is_new] = known.try_emplace({verdict.from, verdict.to}, result.size());
    if (is_new) {
      result.push_back(verdict);
    } else if (LoopVerdict& earlier = result[entry->second]; has_figures(verdict)) {
      earlier = verdict;
    } else {
      earlier.verdict = verdict.verdict;
      earlier.reason = verdict.reason;
    }
  }
  return result;
}

LoopVerdict newest_verdict(const Loop& loop, const Verdicts& verdicts) {
  const auto found = verdicts.find({loop.from, loop.to});
  return found == verdicts.end() ? LoopVerdict{} : found->second;
}

/// Throws InputError for a word that is no index of a key frame.
double index_of(const std::string& word) {
  const double number = finite_number(word);
  if (number >= 0.0 && number <= 4294967295.0 && number == std::floor(number)) return number;
  throw InputError("'" + word + "' is no index");
}

/// The edit of a line without its comment. Throws InputError if it has another form.
LoopEdit edit_of(const std::string& line) {
  std::istringstream words(line);
  std::string word;
  words >> word;
  LoopEdit edit;
  edit.add = word == "add";
  edit.decision = edit.add ? LoopDecision::kAccept : loop_decision_from(word);
  std::vector<double> numbers;
  while (words >> word) numbers.push_back(numbers.size() < 2 ? index_of(word) : coordinate(word));
  const bool has_guess = edit.add && (numbers.size() == 5 || numbers.size() == 8);
  if (numbers.size() != 2 && !has_guess) {
    throw InputError(std::to_string(numbers.size()) + " numbers");
  }
  edit.from = static_cast<KeyFrameIndex>(std::min(numbers[0], numbers[1]));
  edit.to = static_cast<KeyFrameIndex>(std::max(numbers[0], numbers[1]));
  if (has_guess) edit.guess = pose_from_degrees({numbers.begin() + 2, numbers.end()});
  if (has_guess && numbers[0] > numbers[1]) edit.guess = edit.guess->inverse();
  return edit;
}

}  // namespace

void write_loops_csv(const Session& session, const std::filesystem::path& path) {
  const Verdicts verdicts = newest_verdicts(session.verdicts());
  std::ostringstream text;
  text << std::setprecision(12)
       << "from,to,stamp_ns,x,y,z,qx,qy,qz,qw,fitness,overlap,source,decision,verdict,reason\n";
  for (const Loop& loop : session.loops()) {
    const Eigen::Vector3d& t = loop.T_from_to.translation;
    const Eigen::Quaterniond& q = loop.T_from_to.rotation;
    const LoopVerdict verdict = newest_verdict(loop, verdicts);
    text << loop.from << ',' << loop.to << ',' << loop.stamp << ',' << t.x() << ',' << t.y() << ','
         << t.z() << ',' << q.x() << ',' << q.y() << ',' << q.z() << ',' << q.w() << ','
         << loop.fitness << ',' << loop.overlap << ',' << to_string(loop.source) << ','
         << to_string(loop.decision) << ',' << to_string(verdict.verdict) << ','
         << quoted(verdict.reason, '"') << '\n';
  }
  write_text_atomically(path, text.str());
}

void write_candidates_csv(const Session& session, const std::filesystem::path& path) {
  std::ostringstream text;
  text << std::setprecision(6)
       << "from,to,stamp_ns,source,verdict,distance,fitness,overlap,free_space_violation,"
          "horizontal_eigenvalue,innovation,reason\n";
  for (const LoopVerdict& v : candidates(session)) {
    text << v.from << ',' << v.to << ',' << v.stamp << ',' << to_string(v.source) << ','
         << to_string(v.verdict) << ',' << v.distance << ',' << v.fitness << ',' << v.overlap << ','
         << v.free_space_violation << ',' << v.horizontal_eigenvalue << ',' << v.innovation << ','
         << quoted(v.reason, '"') << '\n';
  }
  write_text_atomically(path, text.str());
}

void write_loop_list(const Session& session, const std::filesystem::path& path) {
  const Verdicts verdicts = newest_verdicts(session.verdicts());
  std::ostringstream text;
  text << kListHead << std::fixed << std::setprecision(2);
  for (const Loop& loop : session.loops()) {
    const LoopVerdict verdict = newest_verdict(loop, verdicts);
    text << std::left << std::setw(6) << to_string(loop.decision) << ' ' << loop.from << ' '
         << loop.to << "  # " << to_string(verdict.verdict) << ", overlap " << loop.overlap
         << ", found by " << to_string(loop.source) << ": " << verdict.reason << '\n';
  }
  write_text_atomically(path, text.str());
}

std::vector<LoopEdit> read_loop_list(const std::filesystem::path& path) {
  std::ifstream file = open_for_reading(path);
  std::vector<LoopEdit> edits;
  std::string line;
  for (int number = 1; std::getline(file, line); ++number) {
    const std::string content = line.substr(0, line.find('#'));
    if (content.find_first_not_of(" \t\r") == std::string::npos) continue;
    const std::string where = path.string() + ":" + std::to_string(number);
    try {
      edits.push_back(edit_of(content));
    } catch (const InputError& error) {
      throw InputError(where + ": cannot understand '" + content + "' (" + error.what() +
                       "); wanted auto, accept or refuse FROM TO, or add FROM TO [X Y Z [ROLL "
                       "PITCH YAW]]");
    }
    edits.back().where = where;
  }
  return edits;
}

}  // namespace lidar_mapping::session
