#pragma once
/// The compilations of sine_cosine, one for each instruction set.

namespace hecaton::planner {

using SineCosine = void (*)(const double* angle, int count, double* sine, double* cosine);

namespace baseline {
void sine_cosine(const double* angle, int count, double* sine, double* cosine);
}
namespace avx2 {
void sine_cosine(const double* angle, int count, double* sine, double* cosine);
}

}  // namespace hecaton::planner
