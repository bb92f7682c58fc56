// Signals that excite a process so that it can be identified.

#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace plantloop::identify {

// A maximum-length binary sequence of a register of `bits` (2 to 20) ones, +amplitude where the last bit is 1, else
// -amplitude; each level lasts `hold` samples; a period is (2^bits - 1) hold samples. samples = 0: one period. The same
// sequence as the block `prbs`.
Eigen::VectorXd prbs(int bits, Eigen::Index hold = 1, double amplitude = 1, Eigen::Index samples = 0);

// Independent levels, evenly distributed on (lower, upper), each held for a number of samples drawn evenly from
// hold_least ... hold_most.
Eigen::VectorXd staircase(Eigen::Index samples, Eigen::Index hold_least, Eigen::Index hold_most, double lower,
                          double upper, std::uint64_t seed);

// Normally distributed white noise with this standard deviation.
Eigen::VectorXd white_noise(Eigen::Index samples, double deviation, std::uint64_t seed);
// The same by the generator of Park and Miller, seed 1 ... 2147483646: equal in every language.
Eigen::VectorXd portable_noise(Eigen::Index samples, double deviation, std::uint32_t seed);

// Cosines of the harmonics first ... last of the period, with equal amplitudes and the phases -pi m (m-1)/M of
// M. Schroeder (1970), which keep the crest low; scaled to the greatest absolute value `amplitude`. `last` is below
// period/2.
Eigen::VectorXd multisine(Eigen::Index samples, Eigen::Index period, Eigen::Index first, Eigen::Index last,
                          double amplitude);

// A sine whose frequency grows from `from` to `to` (rad/s) in a straight line.
Eigen::VectorXd chirp(Eigen::Index samples, double Ts, double from, double to, double amplitude);

// +amplitude and -amplitude in turn, each for `half` samples.
Eigen::VectorXd square_wave(Eigen::Index samples, Eigen::Index half, double amplitude);

}  // namespace plantloop::identify
