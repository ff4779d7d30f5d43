// SPDX-License-Identifier: BSD-3-Clause
// Runs the front end over simulated drives with faults and reports errors without a warning.

#include <algorithm>
#include <cstdio>

#include <CLI/CLI.hpp>

#include "lidar_mapping/common/atomic_file.hpp"
#include "lidar_mapping/common/text.hpp"
#include "lidar_mapping/simulation/lidar_model.hpp"

#include "campaign_case.hpp"
#include "campaign_run.hpp"
#include "command_line/number_checks.hpp"
#include "command_line/run_command.hpp"
#include "evidence_table.hpp"
#include "json.hpp"

namespace {

using namespace lidar_mapping;
using campaign::CampaignCase;
using campaign::CampaignFigures;
using json::Json;

struct Options {
  std::vector<std::string> lidars = {"hdl64", "vlp16"};
  std::vector<std::uint64_t> seeds = {51};
  std::string cases;
  std::vector<std::string> lines;
  std::size_t random = 0;
  std::uint64_t seed = 1;
  double duration = 30.0;
  std::string json;
  std::string evidence;
};

/// Every case with every sensor and seed that the case does not fix, then the random cases.
std::vector<CampaignCase> all_runs(const Options& options) {
  std::vector<CampaignCase> cases;
  if (!options.cases.empty()) cases = campaign::read_cases(options.cases);
  for (const std::string& line : options.lines) cases.push_back(campaign::parse_case(line));
  if (cases.empty() && options.random == 0) cases = campaign::usual_cases();
  std::vector<CampaignCase> runs;
  for (const CampaignCase& c : cases) {
    const auto lidars = c.lidar.empty() ? options.lidars : std::vector<std::string>{c.lidar};
    const auto seeds = c.seed ? std::vector<std::uint64_t>{*c.seed} : options.seeds;
    for (const std::string& lidar : lidars) {
      for (const std::uint64_t seed : seeds) {
        runs.push_back(c);
        runs.back().lidar = lidar;
        runs.back().seed = seed;
      }
    }
  }
  simulation::Random random(options.seed);
  for (std::size_t i = 0; i < options.random; ++i) runs.push_back(campaign::random_case(random));
  return runs;
}

void print_head() {
  std::printf("%8s %5s %6s %5s %5s %5s %8s %8s %10s %9s %9s %7s %7s %6s %6s %6s  %s\n", "drift %",
              "scans", "silent", "wrong", "false", "lost", "degraded", "doubtful", "degenerate",
              "largest m", "largest d", "cpu ms", "APE m", "way m", "nees", "edges", "case");
}

std::string text_of(const std::optional<double>& figure, int digits) {
  return figure ? formatted("%.*f", digits, *figure) : "-";
}

void print(const CampaignFigures& f, const std::string& line) {
  std::printf(
      "%8s %5zu %6zu %5zu %5zu %5zu %8zu %8zu %10zu %9.3f %9.2f %7.2f %7.4f %6.1f %6s %6s  "
      "%s\n",
      text_of(f.drift_percent, 4).c_str(), f.scans, f.silent, f.wrong, f.false_alarms, f.lost,
      f.degraded, f.doubtful, f.degenerate, f.largest_error, f.largest_error_deg, f.cpu_ms, f.ape,
      f.path_length, text_of(f.nees_steps, 2).c_str(), text_of(f.nees_edges, 2).c_str(),
      line.c_str());
  std::fflush(stdout);
}

/// Totals of all runs.
struct Totals {
  std::size_t runs = 0, scans = 0, silent = 0, wrong = 0, lost = 0, steps = 0;
  std::size_t clean_scans = 0, clean_alarms = 0;  ///< in runs at full rate without faults
  double squared_error = 0.0;

  void add(const CampaignCase& c, const CampaignFigures& f) {
    ++runs;
    scans += f.scans;
    silent += f.silent;
    wrong += f.wrong;
    lost += f.lost;
    steps += f.steps;
    squared_error += f.squared_error;
    if (!c.faults.empty() || c.every > 1) return;
    clean_scans += f.scans;
    clean_alarms += f.false_alarms;
  }

  void print() const {
    std::printf(
        "%zu runs, %zu scans, %zu wrong steps, %zu of them silent, %zu lost; false alarms on "
        "clean drives: %zu of %zu; Brier score of the probability: %.4f\n",
        runs, scans, wrong, silent, lost, clean_alarms, clean_scans,
        squared_error / static_cast<double>(std::max<std::size_t>(1, steps)));
  }
};

Json or_null(const std::optional<double>& figure) { return figure ? Json(*figure) : Json(); }

Json to_json(const CampaignFigures& f, const std::string& line) {
  return {{"case", line},
          {"scans", f.scans},
          {"drift_percent", or_null(f.drift_percent)},
          {"silent", f.silent},
          {"wrong", f.wrong},
          {"false_alarms", f.false_alarms},
          {"lost", f.lost},
          {"degraded", f.degraded},
          {"doubtful", f.doubtful},
          {"degenerate", f.degenerate},
          {"largest_error_m", f.largest_error},
          {"largest_error_deg", f.largest_error_deg},
          {"cpu_ms", f.cpu_ms},
          {"ape_m", f.ape},
          {"path_length_m", f.path_length},
          {"nees_steps", or_null(f.nees_steps)},
          {"nees_edges", or_null(f.nees_edges)}};
}

void run(const Options& options) {
  const std::vector<CampaignCase> runs = all_runs(options);
  print_head();
  std::optional<campaign::EvidenceTable> table;
  if (!options.evidence.empty()) table.emplace(options.evidence);
  Json all = Json::array();
  Totals totals;
  for (const CampaignCase& c : runs) {
    const std::string line = campaign::to_line(c);
    std::vector<campaign::CheckedStep> steps;
    const CampaignFigures figures = campaign::run_case(c, options.duration, &steps);
    if (table) table->add(line, steps);
    print(figures, line);
    all.push_back(to_json(figures, line));
    totals.add(c, figures);
  }
  totals.print();
  if (table) table->close();
  if (options.json.empty()) return;
  write_text_atomically(
      options.json, json::dumped(Json{{"duration_s", options.duration}, {"runs", all}}, 2) + "\n");
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Odometry over simulated drives with faults: drift, wrong steps, reported states"};
  Options options;
  app.add_option("--lidars", options.lidars, "sensors, with commas between")
      ->check(CLI::IsMember(simulation::lidar_names()))
      ->delimiter(',')
      ->capture_default_str();
  app.add_option("--seeds", options.seeds, "seeds of the worlds, with commas between")
      ->delimiter(',')
      ->capture_default_str();
  app.add_option("--cases", options.cases,
                 "file with a case per line, 'NAME drive=town fault=rain=0.15 ...'; else each "
                 "fault alone");
  app.add_option("--case", options.lines, "one case more, in the same form (repeatable)")
      ->allow_extra_args(false);
  app.add_option("--evidence", options.evidence,
                 "CSV file to write: every step with what it was judged by, for "
                 "fit_step_belief.py");
  app.add_option("--random", options.random, "so many random mixtures of worlds and faults");
  app.add_option("--seed", options.seed, "of the random mixtures")->capture_default_str();
  app.add_option("--duration", options.duration, "seconds of each drive")
      ->check(tools::above_zero())
      ->capture_default_str();
  app.add_option("--json", options.json, "write the figures");
  return tools::run_command(app, argc, argv, [&] { run(options); });
}
