// A compiled diagram: lists of operations over one arena of doubles. Immutable and shared by runs and threads;
// everything that changes during a run lives in the arena and the kernels' states of a Frame.

#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "engine/program/execute.h"
#include "engine/program/operation_graph.h"
#include "engine/program/record.h"
#include "engine/program/smoothing.h"

namespace plantloop {

using SlotIndex = std::uint32_t;

struct Program {
  // The arena: its size and the values it starts with (constants, the parameters' values as compiled).
  std::vector<double> arena;
  // Where things stand in it.
  SlotIndex states = 0;  // the continuous states are contiguous from here, in the Program's order
  SlotIndex time = 0;
  std::vector<SlotIndex> parameters, discretes, modes, segments;
  std::vector<SlotIndex> hits;  // per rate: number k of its latest hit
  // Which state of the Record stands at each place, and the other way round.
  std::vector<std::uint32_t> state_at, place_of_state;

  // What to run when; `roots` of each list are the slots of its results.
  List parameter_list;     // after a parameter changed
  List initial_list;       // once: initial states (by place), then initial discrete states
  List held_list;          // at hits and events, by mask: operations that hold their value in between
  List mode_list;          // roots: the value of each mode by present values
  List guard_list;         // roots: guards, in the order of `guards`
  List derivative_list;    // roots: derivatives by place, contiguous
  List watch_list;         // roots: watched values
  List jump_list;          // roots: the values of all jumps, from the left values
  List hold_list;          // roots: condition and value of each hold, by the values just before a stop or event
  List advance_list;       // roots: inputs of the continuous kernels' advance, one after the other
  List jacobian_list;      // roots: entries of df/dx in the order of the pattern
  List dae_list;           // roots: derivatives by place, then the residuals of `dae_loops`, unknowns as they stand
  List dae_jacobian_list;  // roots: entries of d dae/d(states, unknowns) in the order of the pattern
  List step_list;          // roots: the states after one fixed step by place; empty when the method is not unrolled

  std::vector<SlotIndex> numbers;  // of CompileOptions::numbers (computed by parameter_list)
  std::vector<SlotIndex> nexts;    // per discrete state: its next value (in held_list)

  struct Guard {
    bool is_jump;         // else it guards a mode
    std::uint32_t index;  // of the mode, or of the jump in `jumps`
    int direction;        // jumps: 1 rising, -1 falling, 0 either
    bool continuous;      // can cross zero between hits and events
    int at_zero;          // the sign that zero counts as; 0: whatever the function crosses to
    SlotIndex gate;       // jumps: fires only while this slot is not 0, before and at the event; no_gate: always
  };
  std::vector<Guard> guards;
  struct Jump {
    std::string name;
    std::uint32_t site;
    std::uint32_t first_value;  // in jump_list.roots
    struct Target {
      bool discrete;
      SlotIndex slot;
    };
    std::vector<Target> targets;
    RateIndex triggers = 0;       // the rate that has a hit when it fires
    SlotIndex enabled = no_gate;  // of a trigger: it counts only where this is not 0 at the event
    bool of_kernel = false;       // a kernel's output is not smooth there, and nothing else happens
    bool level = false;           // it also fires where its function is positive when it begins to be looked at
  };
  std::vector<Jump> jumps;
  struct Schedule {
    std::vector<SlotIndex> times;
    SlotIndex first = 0, period = 0;
    bool periodic = false;
    std::uint32_t site = 0;
  };
  std::vector<Schedule> schedules;
  struct KernelState {
    std::shared_ptr<const Kernel> kernel;
    bool continuous;
    Mask mask;
    std::vector<SlotIndex> inputs, advance_inputs;  // of held_list (discrete) or advance_list (continuous)
    std::uint32_t first_state;                      // in the Frame's kernel states
    std::uint32_t first_history;                    // in the Frame's histories
    std::uint32_t site;
    SlotIndex gate = no_gate;  // goes on only while this slot is not 0
    // With histories: the kernels with histories whose outputs reach the first input of its advance, and how many
    // integrations make them smoother on the way.
    std::vector<Smoothed> sources;
  };
  std::vector<KernelState> kernels;
  // What limits a sampled signal, for the report of a run: `value` is at the limit where it equals `limit`.
  struct Limit {
    SlotIndex value, limit;
    std::uint32_t site;
  };
  std::vector<Limit> limits;
  // Unknowns that equations determine together; the lists that read them solve them first.
  struct Loop {
    std::string path;  // "a -> b -> a"
    std::uint32_t site = 0;
    bool initial = false;                                 // of the initial list
    bool exact = true, affine = false, constant = false;  // of the Jacobian, as in the graph's Loop
    Mask mask = 0;                                        // when it is solved
    std::vector<std::string> names;                       // of the unknowns
    SlotIndex unknowns = 0;                               // they stand side by side from here
    std::vector<SlotIndex> lower, upper, guess;           // no_slot: none
    List residual_list;                                   // roots: the residuals, zero at the solution
    List jacobian_list;                                   // roots: the entries of the Jacobian
    List mode_list;                                       // roots: the values of the modes by present values
    std::vector<SlotIndex> modes;                         // of a sampled loop: frozen while it is solved
    std::vector<std::uint32_t> mode_sites;
    std::vector<std::uint32_t> row, column;  // of the entries
    std::uint32_t first_value = 0;           // in the Frame's loop values
    std::uint32_t first_room = 0;            // in the Frame's loop room
    std::size_t size() const { return names.size(); }
  };
  std::vector<Loop> loops;
  List loop_list;  // solves every loop that continuous signals reach
  std::uint32_t loop_value_count = 0, loop_room_size = 0;
  // What a loop that became an expression is divided by: its equations have no solution where it is 0.
  struct Pivot {
    SlotIndex slot;
    std::string path;
    std::uint32_t site;
  };
  std::vector<Pivot> pivots;

  std::uint32_t kernel_state_size = 0;
  std::uint32_t history_count = 0;
  std::uint32_t scratch_size = 0;

  std::vector<SlotIndex> holds;  // the discrete state of each hold
  // The held slots that derivatives read: a run goes on without a restart while none of them changes.
  std::vector<SlotIndex> held_in_derivatives;

  // df/dx by columns; rows are places.
  std::vector<int> jacobian_column_start, jacobian_row;
  // The same for dae_list; columns and rows are places, then unknowns.
  std::vector<int> dae_column_start, dae_row;
  std::vector<std::uint32_t> dae_loops;  // the loops whose unknowns are variables of the solver, in order
  bool jacobian_is_exact = true;
  std::vector<std::string> differenced;  // kernels without derivative, named in the report

  // Exact partial derivatives, when CompileOptions::linear asks for them: entry k is in this row and column and its
  // value stands, once the list has run, in the slot list.roots[k].
  struct PartialList {
    List list;
    std::vector<std::uint32_t> row, column;
  };
  // Columns of both: the states by place, the discrete states, the parameters asked for, the held values, the time.
  struct Linear {
    PartialList flow;               // rows: derivatives by place, then watches
    std::vector<PartialList> hits;  // for each set of rates asked for: held values, then next values, then watches
    std::vector<Mask> held_masks;   // of the held values: when they are computed anew
    std::vector<std::string> held_names;
    std::vector<std::string> missing;  // kernels whose derivative is not known and left out
  };
  Linear linear;

  // From the Record, for messages and settings.
  std::vector<RecordedRate> rates;
  std::vector<RecordedParameter> parameter_info;
  std::vector<std::string> state_names;  // by place
  std::vector<std::uint32_t> state_sites;
  std::vector<std::string> discrete_names;
  std::vector<RateIndex> discrete_rates;
  std::vector<Mask> watch_masks;  // which bits a watched value changes with
  std::vector<std::uint32_t> watch_sites;
  std::vector<Site> sites;

  // The same operations as a graph, for further passes (linearisation, gradients, explain).
  std::shared_ptr<const struct Resolved> resolved;
};

struct CompileOptions {
  std::vector<Value> watches;  // values of the Record
  std::vector<Value>
      numbers;  // values over parameters only, to be read after parameter_list: settings, bounds, expectations
  bool jacobian = true;
  bool loops_are_errors = false;
  bool dae = false;                        // make dae_list for a solver that takes the unknowns of loops as variables
  bool linear = false;                     // make Program::linear
  std::vector<std::uint32_t> linear_by;    // parameters of the Record, as columns
  std::vector<std::uint32_t> linear_open;  // watches that count as constant where they are read
  std::vector<Mask> linear_hits;           // sets of rates with hits at one instant
  std::string unroll_method;               // "euler", "heun" or "rk4": make step_list when the derivatives are few
  double unroll_step = 0;                  // its step size in s
};

// Null after reporting loops that cannot be solved (or any, when they are errors) or initial values that depend on each
// other.
std::shared_ptr<const Program> compile(const Record& record, const CompileOptions& options, class Report& report);

}  // namespace plantloop
