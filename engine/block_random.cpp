// Counters to bits, bits to numbers.

#include "engine/block_random.h"

#include <array>
#include <bit>
#include <cmath>
#include <memory>

#include "engine/program/kernel.h"

namespace plantloop {

namespace {

std::uint64_t mix(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15ULL;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
  return x ^ (x >> 31);
}

// A whole number, or, should a solver try another one, its bits.
std::uint64_t whole(double v) {
  if (std::fabs(v) < 0x1p63) return static_cast<std::uint64_t>(static_cast<std::int64_t>(v));
  return std::bit_cast<std::uint64_t>(v);
}

// log(x) for x > 0 from divisions and a series, so that its bits do not depend on a library:
// x = m 2^e with m in [sqrt(1/2), sqrt(2)), log m = 2 atanh((m - 1)/(m + 1)).
double logarithm(double x) {
  int e = 0;
  double m = std::frexp(x, &e);
  if (m < 0.70710678118654752) {
    m *= 2;
    --e;
  }
  const double z = (m - 1) / (m + 1), z2 = z * z;  // |z| < 0.1716: z^24 is below 1e-18
  double sum = 0;
  for (int k = 23; k >= 1; k -= 2) sum = sum * z2 + 1.0 / k;
  return e * 0.69314718055994531 + 2 * z * sum;
}

double ratio(const std::array<double, 8>& num, const std::array<double, 8>& den, double x) {
  double n = num[7], d = den[7];
  for (std::size_t i = 7; i-- > 0;) {
    n = n * x + num[i];
    d = d * x + den[i];
  }
  return n / d;
}

// A pure function of seed, stream, element and count.
class RandomNumbers final : public Kernel {
 public:
  RandomNumbers(Distribution distribution, std::uint64_t stream, int width)
      : distribution_(distribution), stream_(stream), width_(width) {}
  std::string name() const override { return "random numbers"; }
  int outputs() const override { return width_; }
  void evaluate(const KernelCall& call) const override {
    const std::uint64_t seed = whole(call.in[0]), count = whole(call.in[1]);
    for (int i = 0; i < width_; ++i) {
      const double u = uniform_number(seed, stream_, static_cast<std::uint64_t>(i), count);
      call.out[i] = distribution_ == Distribution::uniform ? u : normal_quantile(u);
    }
  }

 private:
  Distribution distribution_;
  std::uint64_t stream_;
  int width_;
};

}  // namespace

double uniform_number(std::uint64_t seed, std::uint64_t stream, std::uint64_t element, std::uint64_t count) {
  const std::uint64_t bits = mix(mix(mix(mix(seed) ^ stream) + element) + count);
  return (static_cast<double>(bits >> 11) + 0.5) * 0x1p-53;
}

double normal_quantile(double p) {
  static constexpr std::array<double, 8> a{3.3871328727963666080e0,  1.3314166789178437745e+2, 1.9715909503065514427e+3,
                                           1.3731693765509461125e+4, 4.5921953931549871457e+4, 6.7265770927008700853e+4,
                                           3.3430575583588128105e+4, 2.5090809287301226727e+3};
  static constexpr std::array<double, 8> b{1.0,
                                           4.2313330701600911252e+1,
                                           6.8718700749205790830e+2,
                                           5.3941960214247511077e+3,
                                           2.1213794301586595867e+4,
                                           3.9307895800092710610e+4,
                                           2.8729085735721942674e+4,
                                           5.2264952788528545610e+3};
  static constexpr std::array<double, 8> c{
      1.42343711074968357734e0, 4.63033784615654529590e0,  5.76949722146069140550e0,  3.64784832476320460504e0,
      1.27045825245236838258e0, 2.41780725177450611770e-1, 2.27238449892691845833e-2, 7.74545014278341407640e-4};
  static constexpr std::array<double, 8> d{1.0,
                                           2.05319162663775882187e0,
                                           1.67638483018380384940e0,
                                           6.89767334985100004550e-1,
                                           1.48103976427480074590e-1,
                                           1.51986665636164571966e-2,
                                           5.47593808499534494600e-4,
                                           1.05075007164441684324e-9};
  static constexpr std::array<double, 8> e{
      6.65790464350110377720e0,  5.46378491116411436990e0,  1.78482653991729133580e0,  2.96560571828504891230e-1,
      2.65321895265761230930e-2, 1.24266094738807843860e-3, 2.71155556874348757815e-5, 2.01033439929228813265e-7};
  static constexpr std::array<double, 8> f{1.0,
                                           5.99832206555887937690e-1,
                                           1.36929880922735805310e-1,
                                           1.48753612908506148525e-2,
                                           7.86869131145613259100e-4,
                                           1.84631831751005468180e-5,
                                           1.42151175831644588870e-7,
                                           2.04426310338993978564e-15};
  const double q = p - 0.5;
  if (std::fabs(q) <= 0.425) return q * ratio(a, b, 0.180625 - q * q);
  const double r = std::sqrt(-logarithm(q < 0 ? p : 1 - p));
  const double x = r <= 5 ? ratio(c, d, r - 1.6) : ratio(e, f, r - 5);
  return q < 0 ? -x : x;
}

std::vector<Value> random_numbers(Now now, Distribution distribution, Value seed, Value count, int elements) {
  return now.kernel(std::make_shared<RandomNumbers>(distribution, now.stream(), elements), {seed, count});
}

void check_seed(Checking& checking, const Number& seed) {
  const auto given = checking.of(seed);
  if (!given.empty() && given[0] != std::floor(given[0])) checking.problem(seed, "a seed is a whole number");
}

}  // namespace plantloop
