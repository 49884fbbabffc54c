"""Solves projection problems with cvxopt: the independent answer for dense_qp_test.

usage: cvxopt_oracle.py PROBLEMS SOLUTIONS
"""
import sys

from cvxopt import matrix, solvers

solvers.options.update(show_progress=False, abstol=1e-11, reltol=1e-11, feastol=1e-11, maxiters=200)


def read_numbers(path):
    with open(path) as file:
        for line in file:
            yield from (float(word) for word in line.split())


def nearest(identity, minus_target, G, h):
    """'optimal' and the solution, 'infeasible' when a linear programme proves it, else 'undecided'."""
    n = identity.size[0]
    try:
        answer = solvers.qp(identity, minus_target, G, h)
        if answer["status"] == "optimal":
            return ["optimal", *answer["x"]]
    except (ValueError, ArithmeticError):
        pass
    proof = solvers.lp(matrix(0.0, (n, 1)), G, h)
    return ["infeasible" if proof["status"] == "primal infeasible" else "undecided", *([0.0] * n)]


def main(problems, solutions):
    numbers = read_numbers(problems)
    take = lambda count: [next(numbers) for _ in range(count)]
    with open(solutions, "w") as out:
        while True:
            try:
                n = int(next(numbers))
            except StopIteration:
                return
            rows = int(next(numbers))
            target, lower, upper = take(n), take(n), take(n)
            inequalities = [take(n + 1) for _ in range(rows)]
            for j in range(n):
                unit = [0.0] * n
                unit[j] = 1.0
                inequalities.append(unit + [upper[j]])
                inequalities.append([-v for v in unit] + [-lower[j]])
            G = matrix([[row[j] for row in inequalities] for j in range(n)])
            h = matrix([row[n] for row in inequalities])
            identity = matrix(0.0, (n, n))
            identity[:: n + 1] = 1.0
            print(*nearest(identity, matrix([-t for t in target]), G, h), file=out)


main(sys.argv[1], sys.argv[2])
