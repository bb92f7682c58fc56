// The functions of expressions and the names that nothing else may take.

#include "engine/diagram/expression.h"

namespace plantloop {

const std::vector<FunctionSignature>& expression_functions() {
  static const std::vector<FunctionSignature> list{
      {"sin", 1, 1, "sine of an angle in rad"},
      {"cos", 1, 1, "cosine of an angle in rad"},
      {"tan", 1, 1, "tangent of an angle in rad"},
      {"asin", 1, 1, "the angle in [-pi/2, pi/2] whose sine it is"},
      {"acos", 1, 1, "the angle in [0, pi] whose cosine it is"},
      {"atan", 1, 1, "the angle in (-pi/2, pi/2) whose tangent it is"},
      {"atan2", 2, 2, "atan2(y, x): the angle of the point (x, y) in (-pi, pi]"},
      {"sinh", 1, 1, "hyperbolic sine"},
      {"cosh", 1, 1, "hyperbolic cosine"},
      {"tanh", 1, 1, "hyperbolic tangent"},
      {"asinh", 1, 1, "inverse hyperbolic sine"},
      {"acosh", 1, 1, "inverse hyperbolic cosine"},
      {"atanh", 1, 1, "inverse hyperbolic tangent"},
      {"exp", 1, 1, "the exponential function"},
      {"expm1", 1, 1, "exp(x) - 1, exact for small x"},
      {"log", 1, 1, "natural logarithm"},
      {"log1p", 1, 1, "log(1 + x), exact for small x"},
      {"log10", 1, 1, "logarithm to base 10"},
      {"log2", 1, 1, "logarithm to base 2"},
      {"sqrt", 1, 1, "square root"},
      {"cbrt", 1, 1, "cube root, of negative numbers too"},
      {"pow", 2, 2, "pow(x, y): the same as x^y"},
      {"hypot", 2, 2, "hypot(x, y): sqrt(x^2 + y^2) without overflow"},
      {"erf", 1, 1, "error function"},
      {"abs", 1, 1, "absolute value"},
      {"sign", 1, 1, "-1, 0 or 1"},
      {"floor", 1, 1, "the greatest integer that is not greater"},
      {"ceil", 1, 1, "the least integer that is not less"},
      {"round", 1, 1, "the nearest integer; halves go away from zero"},
      {"trunc", 1, 1, "the integer part, towards zero"},
      {"mod", 2, 2, "mod(a, b): a - b*floor(a/b), which has the sign of b"},
      {"min", 1, -1, "the least of the arguments, element by element; of a single vector its least element"},
      {"max", 1, -1, "the greatest of the arguments, element by element; of a single vector its greatest element"},
      {"clamp", 3, 3, "clamp(x, lower, upper): x within its limits"},
      {"where", 3, 3, "where(c, a, b): a where c is not 0, else b"},
      {"sum", 1, 1, "sum of a vector's elements"},
      {"dot", 2, 2, "scalar product of two vectors"},
      {"norm", 1, 1, "Euclidean length of a vector"},
      {"mul", 2, 2, "mul(A, x): product of a matrix with a matrix or a vector"},
      {"transpose", 1, 1, "rows and columns exchanged"},
      {"zeros", 1, 2, "zeros(n): a vector of zeros; zeros(n, m): a matrix"},
      {"ones", 1, 2, "ones(n): a vector of ones; ones(n, m): a matrix"},
      {"eye", 1, 1, "eye(n): the identity matrix"},
  };
  return list;
}

const std::vector<std::string>& reserved_names() {
  static const std::vector<std::string> list = [] {
    std::vector<std::string> names{"time", "index", "previous", "next", "elapsed", "pi",
                                   "inf",  "true",  "false",    "and",  "or",      "not"};
    for (const FunctionSignature& function : expression_functions()) names.emplace_back(function.name);
    return names;
  }();
  return list;
}

}  // namespace plantloop
