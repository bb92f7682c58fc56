// What other tools call a block, and what it is here.

#include "engine/graph/familiar.h"

#include <algorithm>
#include <string>

namespace plantloop {
namespace {

struct Familiar {
  std::string_view theirs;  // lower case, without blanks and underscores
  std::string_view ours;
};

constexpr Familiar all[] = {
    {"delay", "unit_delay for one sample, tapped_delay for several, transport_delay for a time"},
    {"deadtime", "transport_delay"},
    {"timedelay", "transport_delay"},
    {"memory", "unit_delay with a rate, or sample_and_hold, which holds between events"},
    {"limiter", "saturation"},
    {"saturate", "saturation"},
    {"sat", "saturation"},
    {"clip", "saturation"},
    {"adder", "sum, or an expression, a + b"},
    {"add", "sum, or an expression, a + b"},
    {"subtract", "sum with signs, or an expression, a - b"},
    {"multiply", "product, or an expression, a*b"},
    {"divide", "product with signs, or an expression, a/b"},
    {"abs", "an expression, abs(u)"},
    {"sqrt", "an expression, sqrt(u)"},
    {"sin", "an expression, sin(u); or sine, a source"},
    {"fcn", "an expression"},
    {"function", "an expression, or math_function"},
    {"expression", "an expression without type: y: 2*u"},
    {"lag", "first_order"},
    {"pt1", "first_order"},
    {"lowpass", "first_order, or butterworth"},
    {"highpass", "butterworth with kind: highpass"},
    {"bandpass", "butterworth with kind: bandpass"},
    {"filter", "butterworth, first_order, or transfer_function"},
    {"analogfilterdesign", "butterworth"},
    {"derivative", "filtered_derivative"},
    {"zoh", "zero_order_hold"},
    {"sampler", "zero_order_hold"},
    {"integerdelay", "sample_delay"},
    {"ss", "state_space"},
    {"tf", "transfer_function"},
    {"transferfcn", "transfer_function"},
    {"transferfunction", "transfer_function"},
    {"discretetransferfcn", "discrete_transfer_function"},
    {"const", "constant, or an expression"},
    {"input", "an input of a type, inputs: [u]; a source in a diagram"},
    {"inport", "an input of a type, inputs: [u]"},
    {"output", "an output of a type, outputs: [y]; record: in a diagram"},
    {"outport", "an output of a type, outputs: [y]"},
    {"scope", "no block: what is recorded stands under record:, what is drawn under figures:"},
    {"toworkspace", "no block: what is recorded stands under record:"},
    {"tofile", "no block: what is recorded stands under record:"},
    {"display", "no block: what is recorded stands under record:"},
    {"fromworkspace", "from_file, or staircase"},
    {"subsystem", "a type: write it under types:, and use its name"},
    {"mux", "concat, or a list, [a, b]"},
    {"demux", "no block: elements are read with a dot, x.1"},
    {"selector", "select, or elements and slices, x.1 and x.2:5"},
    {"noise", "white_noise, band_limited_noise, or random_levels for even distribution"},
    {"random", "random_levels, or white_noise for normal distribution"},
    {"randomnumber", "white_noise"},
    {"uniformrandomnumber", "random_levels"},
    {"bandlimitedwhitenoise", "band_limited_noise"},
    {"chirpsignal", "chirp"},
    {"triangle", "sawtooth with width: half the period"},
    {"repeatingtable", "repeating_sequence"},
    {"polyval", "polynomial"},
    {"matmul", "matrix_multiply, or an expression, mul(A, x)"},
    {"leadlag", "lead_lag"},
    {"zpk", "zero_pole_gain"},
    {"zeropole", "zero_pole_gain"},
    {"kalman", "kalman_filter"},
    {"discretepidcontroller", "discrete_pid"},
    {"play", "backlash"},
    {"friction", "coulomb_friction"},
    {"coulombviscousfriction", "coulomb_friction"},
    {"ratelimit", "rate_limiter"},
    {"slewrate", "rate_limiter"},
    {"schmitttrigger", "hysteresis"},
    {"lookuptable2d", "lookup_2d"},
    {"hitcross", "hit_crossing"},
    {"zerocrossing", "hit_crossing"},
    {"flipflop", "sr_latch or d_latch"},
    {"srflipflop", "sr_latch"},
    {"dflipflop", "d_latch"},
    {"detectrise", "edge_detector"},
    {"detectfall", "edge_detector with edge: falling"},
    {"detectincrease", "detect_change with of: increase"},
    {"detectdecrease", "detect_change with of: decrease"},
    {"samplehold", "sample_and_hold, or zero_order_hold at a rate"},
    {"counterfreerunning", "sample_counter"},
    {"counterlimited", "sample_counter with upper"},
    {"stopsimulation", "stop"},
    {"assert", "assertion"},
    {"compensator", "lead_lag, or transfer_function"},
    {"pulsegenerator", "pulse"},
    {"sinewave", "sine"},
    {"signalgenerator", "sine, square or pulse"},
    {"time", "clock, or the name time in any expression"},
    {"lookup", "lookup_1d"},
    {"lookuptable", "lookup_1d"},
    {"table", "lookup_1d"},
    {"quantizer", "quantiser"},
    {"if", "switch, or an expression, where(condition, a, b)"},
    {"comparator", "compare, or an expression, a > b"},
    {"and", "logic, or an expression, a and b"},
    {"or", "logic, or an expression, a or b"},
    {"picontroller", "pi"},
    {"pidcontroller", "pid"},
};

}  // namespace

std::string_view familiar_type(std::string_view name) {
  std::string plain;
  for (const char c : name) {
    if (c == '_' || c == '-' || c == ' ') continue;
    plain += c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  }
  const auto* const found =
      std::find_if(std::begin(all), std::end(all), [&](const Familiar& f) { return f.theirs == plain; });
  return found == std::end(all) ? std::string_view() : found->ours;
}

}  // namespace plantloop
