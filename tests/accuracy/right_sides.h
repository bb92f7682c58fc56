// The equations of well-known test problems, written by hand: what a user would program instead of drawing a diagram.
//
// Sources: E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I and II; the Test Set for
// Initial Value Problem Solvers (F. Mazzia, C. Magherini, University of Bari, 2008).

#pragma once

#include <cmath>

namespace plantloop::accuracy {

template <int mu>
struct VanDerPol {
  template <typename T>
  static void rates(T, const T* x, T* rate) {
    rate[0] = x[1];
    rate[1] = mu * (1 - x[0] * x[0]) * x[1] - x[0];
  }
};

struct Brusselator {
  template <typename T>
  static void rates(T, const T* x, T* rate) {
    rate[0] = 1 + x[0] * x[0] * x[1] - 4 * x[0];
    rate[1] = 3 * x[0] - x[0] * x[0] * x[1];
  }
};

// Three bodies, one without mass, in the rotating frame.
struct Arenstorf {
  template <typename T>
  static void rates(T, const T* x, T* rate) {
    using std::sqrt;
    const double m = 0.012277471, n = 1 - m;
    const T a = (x[0] + m) * (x[0] + m) + x[1] * x[1], b = (x[0] - n) * (x[0] - n) + x[1] * x[1];
    const T d1 = a * sqrt(a), d2 = b * sqrt(b);
    rate[0] = x[2];
    rate[1] = x[3];
    rate[2] = x[0] + 2 * x[3] - n * (x[0] + m) / d1 - m * (x[0] - n) / d2;
    rate[3] = x[1] - 2 * x[2] - n * x[1] / d1 - m * x[1] / d2;
  }
};

// Seven stars in the plane: x 0-6, y 7-13, x' 14-20, y' 21-27; the mass of star i is i.
struct Pleiades {
  template <typename T>
  static void rates(T, const T* x, T* rate) {
    using std::sqrt;
    for (int i = 0; i < 14; ++i) rate[i] = x[14 + i];
    for (int i = 0; i < 7; ++i) {
      T fx = 0, fy = 0;
      for (int j = 0; j < 7; ++j) {
        if (j == i) continue;
        const T dx = x[j] - x[i], dy = x[7 + j] - x[7 + i];
        const T r = dx * dx + dy * dy;
        fx = fx + (j + 1) * dx / (r * sqrt(r));
        fy = fy + (j + 1) * dy / (r * sqrt(r));
      }
      rate[14 + i] = fx;
      rate[21 + i] = fy;
    }
  }
};

}  // namespace plantloop::accuracy
