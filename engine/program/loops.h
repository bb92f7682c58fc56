// Which nodes of a Record need each other's value at the same instant, and where to cut them open.
//
// A loop is a strongly connected component of the nodes; its tears are nodes without which it has no closed path. When
// the values of the tears are known, all else in the loop follows in order.

#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "engine/program/record.h"

namespace plantloop {

// The record's values that a node needs first. `initial`: in the list that runs once, in which a state means its
// initial value.
void operands_of(const Record& record, std::uint32_t node, bool initial, std::vector<Value>& into);

struct RecordedLoop {
  enum class Problem {
    none,
    mixed_rates,     // sampled members of several rates, or a closed path without a sampled member beside one with
    no_number,       // a closed path of conditions only
    conditional,     // members that are triggered, or that decide whether members are active
    initial_values,  // initial values of states depend on each other
  };
  std::vector<std::uint32_t> members;  // ascending
  std::vector<std::uint32_t> tears;    // the declared unknowns first, then ascending
  std::vector<std::uint32_t> cycle;    // a closed path, from readers to drivers
  RateIndex rate = 0;                  // at whose hits it is solved; 0: whenever it is read
  Problem problem = Problem::none;
};

// Nothing when every node can be computed in order; loops in the order of their first members.
std::vector<RecordedLoop> find_loops(const Record& record, bool initial);

// The blocks along a closed path of nodes in the direction of the signals, each once in a row, the first by name first.
std::vector<std::uint32_t> sites_along(const Record& record, const std::vector<std::uint32_t>& cycle);
// "a -> b -> a"
std::string closed_path(const Record& record, const std::vector<std::uint32_t>& sites);

}  // namespace plantloop
