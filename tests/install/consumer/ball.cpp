/* A ball that falls on a floor: time, height and velocity after every step, to the last bit. */
#include <cinttypes>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <nsdae/nsdae.hpp>

int main()
{
  nsdae_dims dims = nsdae_dims();
  dims.nq = dims.k = 1;
  nsdae::system ball(dims);
  ball.mass([](double, const double *, double *M, int) { M[0] = 0.1; });
  ball.force([](double, const double *, const double *, double *F) { F[0] = -0.1 * 9.81; });
  ball.gap([](double, const double *q, double *g) { g[0] = q[0]; });
  ball.contact(0, 0, 0.5);
  nsdae::sim sim(ball);
  sim.observe([](const nsdae_record &now) {
    const double value[] = {now.time, now.q[0], now.v[0]};
    std::uint64_t bits[3];
    std::memcpy(bits, value, sizeof bits);
    std::printf("%016" PRIX64 " %016" PRIX64 " %016" PRIX64 "\n", bits[0], bits[1], bits[2]);
  });
  sim.init(0, {1}, {0});
  return sim.run(2) != NSDAE_OK;
}
