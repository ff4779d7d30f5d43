// SPDX-License-Identifier: BSD-3-Clause
#include "evidence_table.hpp"

#include "lidar_mapping/common/errors.hpp"

namespace lidar_mapping::campaign {

EvidenceTable::EvidenceTable(const std::string& path) : path_(path), file_(path) {
  file_ << "case,stamp_ns,state,error_m,error_deg,probability";
  for (const auto& [name, value] : named_figures(front_end::StepEvidence{})) file_ << ',' << name;
  file_ << '\n';
  if (!file_.flush()) throw FileError("cannot write " + path_);
}

void EvidenceTable::add(const std::string& line, const std::vector<CheckedStep>& steps) {
  for (const CheckedStep& step : steps) {
    file_ << '"' << line << "\"," << step.stamp << ',' << to_string(step.status.state) << ','
          << step.error.metres << ',' << step.error.degrees << ',' << step.status.probability;
    for (const auto& [name, value] : named_figures(step.status.evidence)) file_ << ',' << value;
    file_ << '\n';
  }
}

void EvidenceTable::close() {
  if (!file_.flush()) throw FileError("cannot write " + path_);
}

}  // namespace lidar_mapping::campaign
