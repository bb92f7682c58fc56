// What a diagram's blocks wrote, as one flat list of operations with roots: the input of compile().

#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "engine/base/mark.h"
#include "engine/base/rational.h"
#include "engine/program/kernel.h"
#include "engine/program/operations.h"
#include "engine/program/value.h"

namespace plantloop {

// Rates are numbered from 1 in `Record::rates`; 0 is continuous (or constant, where nothing continuous is read).
using RateIndex = std::uint16_t;

struct RecordedNode {
  Op op = Op::constant;
  bool plain = false;            // a comparison that is not to become a mode (`zero_crossing: off`)
  RateIndex rate = 0;            // of the block that wrote it: an operation of a discrete block runs at its hits only
  std::uint16_t activation = 0;  // 0: always; else an index into the enable and trigger bits
  std::uint32_t a = 0, b = 0, c = 0;
  std::uint32_t site = 0;  // index into Record::sites
};

// Provenance: which block wrote an operation, in which method or for which port.
struct Site {
  std::string path;    // of the block
  std::string method;  // "outputs", "derivatives", "wire u", ...
  Mark mark;           // the block's line, or the wire's
};

struct RecordedRate {
  Rational period, offset;  // s; hit k is at offset + k period
  bool triggered = false;   // by an event: it has no period
};

struct RecordedParameter {
  std::string name;  // path, elements with a dot: "controller.K.1.2"
  double value = 0;
  std::string unit;
};

struct RecordedState {
  std::string name;  // path of the block, the state's name where a block has several, elements with a dot
  std::uint32_t site = 0;
  Value derivative;
  Value initial;  // may read parameters, time, states (their initial values) and signals
  std::string unit;
};

// An unknown that its own equation determines: `residual` is zero there.
struct RecordedUnknown {
  std::string name;  // path of the block, elements with a dot
  std::uint32_t site = 0;
  Value residual;
  Value lower, upper, guess;  // over parameters only; without bounds: minus and plus infinity
};

struct RecordedDiscrete {
  std::string name;
  std::uint32_t site = 0;
  RateIndex rate = 0;
  Value next;
  Value initial;
  std::string unit;
};

// An element of a block's output, or of an input, by its full name; what may be recorded.
struct RecordedSignal {
  std::string name;  // "plant.ps", "xh.3"
  Value value;
  std::string unit;
  RateIndex rate = 0;  // of the block, 0: continuous or constant
};

struct RecordedJump {
  std::string name;  // "h.reset", "x.upper"
  std::uint32_t site = 0;
  Value function;
  int direction = 0;       // 1 rising, -1 falling, 0 either
  int at_zero = 0;         // the sign that zero counts as; 0: whatever the function crosses to
  bool of_slope = false;   // it fires where the function's derivative by time crosses zero
  bool of_kernel = false;  // a kernel's output is not smooth there, and nothing else happens
  bool level = false;      // it also fires where the function is positive when it begins to be looked at
  RateIndex rate = 0;
  struct Assignment {
    bool discrete;
    std::uint32_t index;
    Value value;  // from the values just before the event
  };
  std::vector<Assignment> assignments;
  std::uint16_t activation = 0;  // fires only while this holds, before and at the event
  RateIndex triggers = 0;        // the rate that has a hit when it fires; 0: none
  Value enabled = 1.0;           // of a trigger: it counts only where this is not 0 at the event
};

// A value that stays as it is from the instant at which a condition ends: the discrete state `index` takes the value
// just before each stop and event, as long as the condition holds.
struct RecordedHold {
  Value condition, value;
  std::uint32_t index = 0;
};

// The instants of a source: `times`, ascending, or first + k period.
struct RecordedSchedule {
  std::vector<Value> times;
  Value first, period;
  bool periodic = false;
  std::uint32_t site = 0;
};

struct Record {
  std::vector<RecordedNode> nodes;
  std::vector<double> constants;
  std::vector<Value> wires;  // the driver of each forward reference
  std::vector<std::uint8_t> wire_bound;
  std::vector<KernelUse> kernels;
  std::vector<Site> sites;          // 0: nowhere
  std::vector<RecordedRate> rates;  // 0 is unused
  std::vector<RecordedParameter> parameters;
  std::vector<RecordedState> states;
  std::vector<RecordedDiscrete> discretes;
  std::vector<RecordedUnknown> unknowns;
  std::vector<RecordedSignal> signals;
  std::vector<RecordedJump> jumps;
  std::vector<RecordedSchedule> schedules;
  std::vector<Value> activations;  // 0 is unused; each is 0 or 1 and changes at hits and events only
  std::vector<RecordedHold> holds;
  Record() : sites(1), rates(1), activations(1) {}
};

// Writes a Record. The newest living Recorder of a thread is the one that Values are recorded by.
class Recorder final : public OperationSink {
 public:
  Recorder();
  ~Recorder() override;
  Recorder(const Recorder&) = delete;
  Recorder& operator=(const Recorder&) = delete;
  static Recorder* current();

  // Stamped on every operation recorded from now on.
  std::uint32_t site = 0;
  RateIndex rate = 0;
  std::uint16_t activation = 0;
  bool plain = false;

  std::uint32_t add_site(std::string path, std::string method, const Mark& mark);
  RateIndex add_rate(const Rational& period, const Rational& offset);  // the same number for equal rates
  RateIndex add_trigger();                                             // a rate whose hits are events
  Value parameter(std::string name, double value, std::string unit = {});
  Value time();
  Value state(std::uint32_t index);            // index into record.states
  Value discrete(std::uint32_t index);         // index into record.discretes; latched by a copy at the state's rate
  Value discrete_before(std::uint32_t index);  // the same, sampled at the recorder's rate; before an update there
  Value implicit(std::uint32_t index);         // index into record.unknowns
  Value hit(RateIndex rate);
  Value segment(std::vector<Value> times);
  Value beats(Value first, Value period);
  Value wire();  // a forward reference
  void bind(Value wire, Value driver);
  std::vector<Value> kernel(KernelUse use);
  Value operation(Op op, Value a, Value b, Value c) override;
  std::uint32_t id_of(Value value);  // a known number becomes a constant node

  Record record;

 private:
  Value leaf(Op op, std::uint32_t index);
  Value copy(Op op, std::uint32_t index, RateIndex changes, RateIndex reads);
  SinkInCharge charge_;
  Recorder* previous_;
  std::vector<std::uint32_t> latches_;  // of discrete states, 0xffffffff: none yet
};

}  // namespace plantloop
