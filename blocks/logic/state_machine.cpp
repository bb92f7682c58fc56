// A state machine.
//
// What a diagram writes is turned into this block by engine/graph/state_machine.cpp: the list port has the guards of
// the transitions, and the texts are "3" for `initial`, "low high" for `states`, "1 2 2 1" for from and to of
// `transitions`.

#include <sstream>

#include "engine/block.h"

namespace plantloop {
namespace {

struct StateMachine final : Block {
  static constexpr auto summary = "Be in one of several states, and go from one to another when a condition holds.";
  static constexpr auto details =
      "states: {name: {set: {output: value}}}. In each state every output has a value, an expression over the inputs, "
      "the parameters around and elapsed, the time in s since the state was entered.\n"
      "transitions: [{from: name, to: name, when: condition}]. One is taken as soon as the machine is in `from` and "
      "the condition holds: at the instant at which it begins to hold, which is located where it is continuous, at a "
      "sample where it is sampled (rate:, or inputs that are), also at the start and on entering a state. Where "
      "several hold, the first one in the list is taken; several may follow each other in one instant.\n"
      "The inputs have names of their own, and conditions see nothing but them, parameters and elapsed. The main "
      "output, state, is the number of the state, from 1 in the order of the file. An event for expect: is the "
      "entering of a state, {event: gear.second, count: 1}.";
  static constexpr auto written =
      "in: {u: a}, initial: low, states: {low: {set: {y: 0}}, high: {set: {y: 1}}}, transitions: [{from: low, to: "
      "high, when: u > 0.9}, {from: high, to: low, when: u < 0.5 and elapsed > 0.1}]";
  static constexpr auto example = R"(
title: A pump that rests for a second after each run
blocks:
  level: {type: integrator, in: 0.5 - pump.flow, initial: 1}
  pump:
    type: state_machine
    in: {level: level}
    initial: off
    states:
      off: {set: {flow: 0}}
      on: {set: {flow: 2}}
      resting: {set: {flow: 0}}
    transitions:
      - {from: off, to: on, when: level > 2}
      - {from: on, to: resting, when: level < 0.5}
      - {from: resting, to: off, when: elapsed > 1}
simulation: {stop: 8}
record: [level, pump.state, pump.flow]
expect:
  - {signal: level, at: 3, value: 0.5, abs: 1e-9}
  - {signal: pump.state, at: 3.5, value: 3}
  - {signal: pump.state, at: 4.5, value: 1}
  - {event: pump.on, count: 2}
)";

  Inputs guards{this, "signals", {.doc = "the signals that conditions and values read, by name: in: {level: tank.h}"}};
  Text initial_state{this, "initial", {.doc = "the state at the start"}};
  Text states{this, "states", {.doc = "names, with the outputs that are set in each"}};
  Text transitions{this, "transitions", {.doc = "a list of {from, to, when}, by falling priority"}};
  Discrete number{this, "number", {.doc = "the number of the state", .size = scalar}};
  Discrete entered{this, "entered", {.unit = "s", .doc = "when it was entered", .size = scalar}};
  Output state{this,
               "state",
               {.doc = "the number of the state, from 1; what the states set are further outputs", .size = scalar}};
  Output elapsed{this, "elapsed", {.doc = "the time since it was entered", .unit = "s", .size = scalar}};

  RateKind rate_kind() const override { return RateKind::watching; }

  void initial(Now now, Init init) const override {
    init[number] = std::stod(initial_state.value());
    init[entered] = now.time();
  }
  void outputs(Now now, Out out) const override {
    out[state] = now[number];
    out[elapsed] = now.time() - now[entered];
  }
  void jumps(Now now, Jumps jump) const override {
    std::vector<std::string> names(1);
    std::istringstream list(states.value());
    for (std::string name; list >> name;) names.push_back(name);
    std::istringstream pairs(transitions.value());
    const std::vector<Array> conditions = now[guards];
    std::vector<Truth> taken(names.size(), Truth(0.0));  // by state: whether a transition out of it is taken already
    std::size_t i = 0;
    for (std::size_t from = 0, to = 0; pairs >> from >> to; ++i) {
      const Truth holds = equal(now[number][0], Value(static_cast<double>(from))) && Truth(conditions[i][0]);
      Crossing crossing = becomes(Truths{Array((holds && !taken[from]).value())});
      crossing.level = true;
      crossing.name = names[to];
      jump.when(crossing).set(number, Array(static_cast<double>(to))).set(entered, Array(now.time()));
      taken[from] = taken[from] || holds;
    }
  }
};

}  // namespace

PLANTLOOP_BLOCK(state_machine, StateMachine)

}  // namespace plantloop
