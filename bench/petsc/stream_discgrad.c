/* PETSc's TSDISCGRAD on TR171's stream, the peer of bench_conserving: Gonzalez' discrete gradient
 * by Newton's method with the analytic Jacobian and a dense LU, one process.
 *
 *     petsc_stream N h STEPS < positions and velocities, N lines of x y vx vy
 *
 * prints microseconds a step and the largest energy error, in the scene's units:
 * F = -6 r^-7 + 9 r^-10, V = -r^-6 + r^-9, all masses 1. */
#include <petscts.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

typedef struct stream {
    PetscInt n; /* particles: the state is x|y|vx|vy */
} stream;

/* For s = r^2: V, F/r, and (1/r) d(F/r)/dr. */
typedef struct pair {
    double potential, over_r, slope;
} pair;

static pair pair_at(double s) {
    const double i = 1 / sqrt(s), i2 = i * i, i6 = i2 * i2 * i2, i9 = i6 * i2 * i;
    return (pair){i9 - i6, (9 * i9 - 6 * i6) * i2, (48 * i6 - 99 * i9) * i2 * i2};
}

static PetscErrorCode skew(TS ts, PetscReal t, Vec y, Mat s, void *context) {
    const PetscInt half = 2 * ((stream *)context)->n;
    (void)ts, (void)t, (void)y;
    PetscFunctionBegin;
    for (PetscInt k = 0; k < half; k++) {
        PetscCall(MatSetValue(s, k, half + k, 1, INSERT_VALUES));
        PetscCall(MatSetValue(s, half + k, k, -1, INSERT_VALUES));
    }
    PetscCall(MatAssemblyBegin(s, MAT_FINAL_ASSEMBLY));
    PetscCall(MatAssemblyEnd(s, MAT_FINAL_ASSEMBLY));
    PetscFunctionReturn(0);
}

static PetscErrorCode energy(TS ts, PetscReal t, Vec y, PetscScalar *value, void *context) {
    const PetscInt n = ((stream *)context)->n;
    const PetscScalar *q;
    (void)ts, (void)t;
    PetscFunctionBegin;
    PetscCall(VecGetArrayRead(y, &q));
    *value = 0;
    for (PetscInt k = 2 * n; k < 4 * n; k++)
        *value += q[k] * q[k] / 2;
    for (PetscInt i = 0; i < n; i++)
        for (PetscInt j = i + 1; j < n; j++) {
            const double dx = q[i] - q[j], dy = q[n + i] - q[n + j];
            *value += pair_at(dx * dx + dy * dy).potential;
        }
    PetscCall(VecRestoreArrayRead(y, &q));
    PetscFunctionReturn(0);
}

static PetscErrorCode gradient(TS ts, PetscReal t, Vec y, Vec out, void *context) {
    const PetscInt n = ((stream *)context)->n;
    const PetscScalar *q;
    PetscScalar *g;
    (void)ts, (void)t;
    PetscFunctionBegin;
    PetscCall(VecGetArrayRead(y, &q));
    PetscCall(VecGetArrayWrite(out, &g));
    for (PetscInt k = 0; k < 4 * n; k++)
        g[k] = k < 2 * n ? 0 : q[k];
    for (PetscInt i = 0; i < n; i++)
        for (PetscInt j = i + 1; j < n; j++) {
            const double dx = q[i] - q[j], dy = q[n + i] - q[n + j];
            const double f = pair_at(dx * dx + dy * dy).over_r;
            g[i] -= f * dx;
            g[j] += f * dx;
            g[n + i] -= f * dy;
            g[n + j] += f * dy;
        }
    PetscCall(VecRestoreArrayWrite(out, &g));
    PetscCall(VecRestoreArrayRead(y, &q));
    PetscFunctionReturn(0);
}

/* y' = (v, -grad V): for TSDISCGRAD's Jacobian, which it takes at the middle. */
static PetscErrorCode rhs(TS ts, PetscReal t, Vec y, Vec out, void *context) {
    const PetscInt half = 2 * ((stream *)context)->n;
    PetscScalar *f;
    PetscFunctionBegin;
    PetscCall(gradient(ts, t, y, out, context));
    PetscCall(VecGetArray(out, &f));
    for (PetscInt k = 0; k < half; k++) {
        const PetscScalar force = -f[k];
        f[k] = f[half + k];
        f[half + k] = force;
    }
    PetscCall(VecRestoreArray(out, &f));
    PetscFunctionReturn(0);
}

/* d f/d d of a pair, as [row][column]. */
static void add_block(PetscScalar *a, PetscInt n, PetscInt i, PetscInt j, double sign,
                      const double block[2][2]) {
    for (PetscInt r = 0; r < 2; r++)
        for (PetscInt c = 0; c < 2; c++)
            a[(2 * n + r * n + i) + (c * n + j) * 4 * n] += sign * block[r][c];
}

static PetscErrorCode jacobian(TS ts, PetscReal t, Vec y, Mat a, Mat p, void *context) {
    const PetscInt n = ((stream *)context)->n;
    const PetscScalar *q;
    PetscScalar *values;
    (void)ts, (void)t, (void)a;
    PetscFunctionBegin;
    PetscCall(MatZeroEntries(p));
    PetscCall(VecGetArrayRead(y, &q));
    PetscCall(MatDenseGetArray(p, &values));
    for (PetscInt k = 0; k < 2 * n; k++)
        values[k + (2 * n + k) * 4 * n] = 1;
    for (PetscInt i = 0; i < n; i++)
        for (PetscInt j = i + 1; j < n; j++) {
            const double d[2] = {q[i] - q[j], q[n + i] - q[n + j]};
            const pair at = pair_at(d[0] * d[0] + d[1] * d[1]);
            double block[2][2];
            for (int r = 0; r < 2; r++)
                for (int c = 0; c < 2; c++)
                    block[r][c] = (r == c ? at.over_r : 0) + at.slope * d[r] * d[c];
            add_block(values, n, i, i, 1, block);
            add_block(values, n, j, j, 1, block);
            add_block(values, n, i, j, -1, block);
            add_block(values, n, j, i, -1, block);
        }
    PetscCall(MatDenseRestoreArray(p, &values));
    PetscCall(VecRestoreArrayRead(y, &q));
    PetscCall(MatAssemblyBegin(p, MAT_FINAL_ASSEMBLY));
    PetscCall(MatAssemblyEnd(p, MAT_FINAL_ASSEMBLY));
    PetscFunctionReturn(0);
}

static double seconds(void) {
    struct timespec now;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static PetscErrorCode read_state(PetscInt n, Vec y) {
    PetscScalar *q;
    PetscFunctionBegin;
    PetscCall(VecGetArrayWrite(y, &q));
    for (PetscInt i = 0; i < n; i++)
        if (scanf("%lf %lf %lf %lf", &q[i], &q[n + i], &q[2 * n + i], &q[3 * n + i]) != 4)
            SETERRQ(PETSC_COMM_SELF, PETSC_ERR_FILE_READ, "particle %d", (int)i);
    PetscCall(VecRestoreArrayWrite(y, &q));
    PetscFunctionReturn(0);
}

static PetscErrorCode set_up(stream *scene, double h, TS *ts, Mat *p) {
    SNES snes;
    KSP ksp;
    PC pc;
    PetscFunctionBegin;
    PetscCall(MatCreateSeqDense(PETSC_COMM_SELF, 4 * scene->n, 4 * scene->n, NULL, p));
    PetscCall(TSCreate(PETSC_COMM_SELF, ts));
    PetscCall(TSSetType(*ts, TSDISCGRAD));
    PetscCall(TSDiscGradSetFormulation(*ts, skew, energy, gradient, scene));
    PetscCall(TSDiscGradUseGonzalez(*ts, PETSC_TRUE));
    PetscCall(TSSetRHSFunction(*ts, NULL, rhs, scene));
    PetscCall(TSSetRHSJacobian(*ts, *p, *p, jacobian, scene));
    PetscCall(TSSetTimeStep(*ts, h));
    PetscCall(TSSetMaxSteps(*ts, 1000000000));
    PetscCall(TSSetMaxTime(*ts, 1e100));
    PetscCall(TSSetExactFinalTime(*ts, TS_EXACTFINALTIME_STEPOVER));
    PetscCall(TSGetSNES(*ts, &snes));
    PetscCall(SNESSetTolerances(snes, 1e-14, 1e-13, 1e-15, 50, 1000));
    PetscCall(SNESGetKSP(snes, &ksp));
    PetscCall(KSPSetType(ksp, KSPPREONLY));
    PetscCall(KSPGetPC(ksp, &pc));
    PetscCall(PCSetType(pc, PCLU));
    PetscCall(TSSetFromOptions(*ts));
    PetscFunctionReturn(0);
}

int main(int argc, char **argv) {
    if (argc < 4)
        return fprintf(stderr, "usage: petsc_stream N h STEPS [PETSc's options] < state\n"), 2;
    stream scene = {atoi(argv[1])};
    const double h = atof(argv[2]);
    const int steps = atoi(argv[3]);
    double used = 0, worst = 0, first, now;
    Vec y;
    Mat p;
    TS ts;
    PetscFunctionBeginUser;
    PetscCall(PetscInitialize(&argc, &argv, NULL, NULL));
    PetscCall(VecCreateSeq(PETSC_COMM_SELF, 4 * scene.n, &y));
    PetscCall(read_state(scene.n, y));
    PetscCall(set_up(&scene, h, &ts, &p));
    PetscCall(TSSetSolution(ts, y));
    PetscCall(energy(ts, 0, y, &first, &scene));
    for (int k = 0; k < steps; k++) {
        const double began = seconds();
        PetscCall(TSStep(ts));
        used += seconds() - began;
        PetscCall(energy(ts, 0, y, &now, &scene));
        worst = fmax(worst, fabs(now - first));
    }
    printf("petsc %.3f us %.3e\n", used / steps * 1e6, worst);
    PetscCall(TSDestroy(&ts));
    PetscCall(MatDestroy(&p));
    PetscCall(VecDestroy(&y));
    PetscCall(PetscFinalize());
    return 0;
}
