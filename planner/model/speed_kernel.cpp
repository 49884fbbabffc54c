#include "planner/model/speed_kernel.hpp"

#include "planner/simd/lanes.hpp"

namespace hecaton::planner::HECATON_ISA {

// Joint j moves the ball's centre c with ω × c + v, whose length is the distance from j's axis, and every other point
// at most |ω| r faster: the bound is Σⱼ |q̇ⱼ| (|ω × c + v| + |ω| r).
void bound_speeds(const JointMotions& motions, const double* speed, CarriedBall* balls, int count) {
  const double* const* const w = motions.angular_W;
  const double* const* const v = motions.linear_W;
  const Lanes counting{0.0, 1.0, 2.0, 3.0};
  for (int i = 0; i < count; ++i) {
    CarriedBall& ball = balls[i];
    const double* X = ball.X_WL;
    const double* c = ball.centre_L;
    store(ball.centre_W, load(X) * c[0] + load(X + 4) * c[1] + load(X + 8) * c[2] + load(X + 12));
    const double* p = ball.centre_W;
    Lanes sum{};
    for (int j = 0; j < ball.joints; j += kLanes) {
      const Vector<Lanes> angular{load(w[0] + j), load(w[1] + j), load(w[2] + j)};
      const Vector<Lanes> centre{angular.y * p[2] - angular.z * p[1] + load(v[0] + j),
                                 angular.z * p[0] - angular.x * p[2] + load(v[1] + j),
                                 angular.x * p[1] - angular.y * p[0] + load(v[2] + j)};
      // ω is a unit vector or zero, so that |ω| = ω · ω.
      const Lanes fastest = load(speed + j) * (sqrt(dot(centre, centre)) + dot(angular, angular) * ball.radius);
      sum += select(counting + j < all<Lanes>(ball.joints), fastest, Lanes{});
    }
    ball.fastest = (sum[0] + sum[2]) + (sum[1] + sum[3]);
  }
}

}  // namespace hecaton::planner::HECATON_ISA
