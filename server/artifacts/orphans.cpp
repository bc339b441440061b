// SPDX-License-Identifier: GPL-3.0-or-later
#include "artifacts/orphans.hpp"

namespace surfaced {
namespace {

std::string name_of(const Claim& claim) { return claim.job + "-" + std::to_string(claim.attempt); }

}  // namespace

Result<std::size_t> OrphanSweep::look() {
  const auto listed = artifacts_.listing();
  if (!listed) return listed.error();
  const auto kept = jobs_.kept();
  if (!kept) return kept.error();
  std::set<std::string> known;
  for (const std::string& key : kept->inputs) known.insert("input " + key);
  for (const Claim& claim : kept->outputs) known.insert("output " + name_of(claim));
  std::set<std::string> suspects;
  Artifacts orphans;
  const auto seen_before = [&](const std::string& name) {
    if (known.contains(name)) return false;
    if (suspects_.contains(name)) return true;
    suspects.insert(name);
    return false;
  };
  for (const std::string& key : listed->inputs) {
    if (seen_before("input " + key)) orphans.inputs.push_back(key);
  }
  for (const Claim& claim : listed->outputs) {
    if (seen_before("output " + name_of(claim))) orphans.outputs.push_back(claim);
  }
  artifacts_.remove(orphans);
  suspects_ = std::move(suspects);
  return orphans.inputs.size() + orphans.outputs.size();
}

}  // namespace surfaced
