"""A balloon's membrane in FEniCSx and here, on the same mesh of linear triangles.

usage: balloon_membrane solve SHAPE AROUND | python3 balloon_membrane.py SHAPE   (balloon_membrane.sh)

FEniCSx gets the energy in the solid's principal invariants, with the thickness that
incompressibility leaves, and the work of the pressure on the enclosed volume; it differentiates
them itself and finds the equilibrium by Newton's method, from the shape blown up by 5 %.
"""
import sys

import numpy as np
import ufl
from dolfinx import fem, mesh
from dolfinx.fem import petsc
from mpi4py import MPI
from petsc4py import PETSc

BAR = 0.01  # of the largest displacement


def read(lines):
    """Numbers of the model; start, fixed axes and our equilibrium by vertex; triangles."""
    words = next(lines).split()
    vertex_count, triangle_count = int(words[0]), int(words[1])
    rows = np.array([[float(w) for w in next(lines).split()] for _ in range(vertex_count)])
    triangles = np.array([[int(w) for w in next(lines).split()] for _ in range(triangle_count)])
    return [float(w) for w in words[2:]], rows, triangles


def potential(u, surface, c1, c2, wall, pressure):
    """Elastic energy of the skin less the work of the pressure [MPa mm^3]."""
    start = ufl.SpatialCoordinate(surface)
    jacobian = ufl.Jacobian(surface)
    area = ufl.cross(jacobian[:, 0], jacobian[:, 1])
    normal = area / ufl.sqrt(ufl.dot(area, area))
    gradient = ufl.Identity(3) - ufl.outer(normal, normal) + ufl.grad(u)
    c = gradient.T * gradient  # in the surface
    trace = ufl.tr(c)
    squared_area = 0.5 * (trace * trace - ufl.tr(c * c))
    squared_thickness = 1 / squared_area
    i1 = trace + squared_thickness
    i2 = squared_area + trace * squared_thickness
    energy = wall * (c1 * (i1 - 3) + c2 * (i2 - 3))
    # Outward, of shapes that are convex around the origin.
    deformed = gradient * jacobian
    outward = ufl.sign(ufl.dot(area, start)) / ufl.sqrt(ufl.dot(area, area))
    volume = outward * ufl.dot(start + u, ufl.cross(deformed[:, 0], deformed[:, 1])) / 3
    return (energy - pressure * volume) * ufl.dx


def solve(u, form, fixed):
    """Newton's method; each step as far as it lessens the residual."""
    space = u.function_space
    slope = ufl.derivative(form, u, ufl.TestFunction(space))
    residual = fem.form(slope)
    tangent = fem.form(ufl.derivative(slope, u, ufl.TrialFunction(space)))

    def force():
        vector = petsc.assemble_vector(residual)
        vector.array[fixed] = 0.0
        return vector

    vector = force()
    first = vector.norm()
    solver = PETSc.KSP().create(MPI.COMM_WORLD)
    solver.setType("preonly")
    solver.getPC().setType("lu")
    for _ in range(60):
        if vector.norm() < 1e-11 * first:
            return True
        matrix = petsc.assemble_matrix(tangent)
        matrix.assemble()
        matrix.zeroRowsColumns(fixed, 1.0)
        solver.setOperators(matrix)
        step = vector.duplicate()
        solver.solve(vector, step)
        before, share = u.x.array.copy(), 1.0
        while share > 1e-4:
            u.x.array[:] = before - share * step.array
            trial = force()
            if trial.norm() < vector.norm():
                break
            share *= 0.5
        vector = trial
    return False


def main():
    (c1, c2, wall, pressure), rows, triangles = read(iter(sys.stdin))
    start, ours = rows[:, :3], rows[:, 4:]
    element = ufl.VectorElement("Lagrange", ufl.Cell("triangle", geometric_dimension=3), 1)
    surface = mesh.create_mesh(MPI.COMM_WORLD, triangles, start, ufl.Mesh(element))
    space = fem.VectorFunctionSpace(surface, ("Lagrange", 1))
    places = {tuple(np.round(p, 9) + 0.0): v for v, p in enumerate(start)}
    vertex = [places[tuple(np.round(p, 9) + 0.0)] for p in space.tabulate_dof_coordinates()]
    axes = rows[vertex, 3].astype(int)
    fixed = np.array([3 * d + a for d, f in enumerate(axes) for a in range(3) if f >> a & 1], np.int32)
    u = fem.Function(space)
    u.x.array[:] = 0.05 * start[vertex].reshape(-1)
    u.x.array[fixed] = 0.0
    converged = solve(u, potential(u, surface, c1, c2, wall, pressure), fixed)
    moved = (ours - start)[vertex]
    off = np.linalg.norm(u.x.array.reshape(-1, 3) - moved, axis=1)
    largest = np.linalg.norm(moved, axis=1).max()
    good = converged and off.max() <= BAR * largest
    print(f"| {sys.argv[1]} | {len(start)} | {largest:.4f} | {off.max() / largest:.1e} | {BAR} "
          f"| {'pass' if good else 'FAIL'} |")
    return 0 if good else 1


sys.exit(main())
