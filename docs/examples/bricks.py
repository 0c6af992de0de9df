"""A ball breaks through a wall of bricks: the bodies of a scene file."""
import nsdae

world = nsdae.read_scene("data/scene_wall.csv")  # 45 bricks, and a ball with 8 m/s
run = nsdae.solve(world, 1, method="moreau", dt=world.scene.dt, contact_tol=1e-4, contact_work=1e5)
print(f"{len(run) - 1} steps, {len(run.impacts)} impacts; the ball is at x = {run.q[-1, -7]:.1f} m")
