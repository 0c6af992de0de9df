#include <nsdae/nsdae.hpp>
#include <cstdio>

int main()
{
  nsdae_rigid_body body = nsdae_rigid_body();
  body.mass = 0.1; // kg
  body.inertia[2] = 1.25e-4; // kg m^2
  body.position[1] = 1.05; // m: the ball has the radius 0.05, its lowest point is 1 m above the floor
  nsdae_solid disc = nsdae_solid(), plane = nsdae_solid();
  disc.shape = NSDAE_SHAPE_DISC;
  disc.radius = 0.05;
  plane.shape = NSDAE_SHAPE_PLANE;
  try {
    nsdae::bodies world(2);
    world.gravity(0, -9.81); // m/s^2
    const int ball = world.solid(world.add(body), disc), floor = world.solid(NSDAE_GROUND, plane);
    world.contact(ball, floor, 0, 0.5); // mu, e_N

    nsdae::sim sim(world.system()); // default options: implicit, dt 0.005 s
    if (world.last_error()->status > 0) std::puts(world.last_error()->text); // a warning
    const auto start = world.start();
    sim.init(0, start.first, start.second);
    if (sim.run(3) > 0) std::puts(sim.last_error()->text); // a warning
    const nsdae_record now = sim.record();
    std::printf("t %g s, height %.1e m, velocity %.1e m/s\n", now.time, now.gap[0], now.v[1]);
  } catch (const nsdae::error &error) {
    std::printf("%s\n", error.what());
    return 1;
  }
}
