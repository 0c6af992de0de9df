#include <nsdae/nsdae.hpp>
#include <cstdio>

int main()
{
  nsdae_dims dims = nsdae_dims();
  dims.nq = dims.k = 1; // one coordinate, one contact
  try {
    nsdae::system ball(dims);
    ball.mass([](double, const double *, double *M, int) { M[0] = 0.1; }); // kg
    ball.force([](double, const double *, const double *, double *F) { F[0] = -0.1 * 9.81; }); // N
    ball.gap([](double, const double *q, double *g) { g[0] = q[0]; }); // height above the floor [m]
    ball.contact(0, 0, 0.5); // of contact 0: mu, e_N

    nsdae::sim sim(ball); // default options: implicit, dt 0.005 s
    sim.init(0, {1}, {0});
    sim.run(3);
    const nsdae_record now = sim.record();
    std::printf("t %g s, height %.1e m, velocity %.1e m/s\n", now.time, now.q[0], now.v[0]);
  } catch (const nsdae::error &error) {
    std::printf("%s\n", error.what());
    return 1;
  }
}
