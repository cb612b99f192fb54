#ifndef TIEROD_NO_MAIN
static int read_row(FILE *file, double *row, int count)
{
    int k;

    for (k = 0; k < count; k++) {
        char text[64] = "nan";
        if (fscanf(file, " %63[^,\n]%*[,]", text) != 1 && k == 0) {
            return 0;
        }
        row[k] = strtod(text, NULL);
    }
    return 1;
}

static FILE *opened(const char *name)
{
    FILE *file = fopen(name, "r");
    int letter;

    if (file == NULL) {
        (void)printf("%s cannot be read\n", name);
        exit(3);
    }
    do {
        letter = fgetc(file);
    } while ((letter != '\n') && (letter != EOF));
    return file;
}

/* Fails where an output is beyond its tolerance in more rows than it may be. */
int main(int count, char **words)
{
    static double u[INPUTS + 1], y[OUTPUTS + 1], wanted[OUTPUTS + 2], worst[OUTPUTS + 1];
    static long beyond[OUTPUTS + 1];
    static const double tolerance[OUTPUTS + 1] = TOLERANCES;
    FILE *inputs = opened((count > 1) ? words[1] : "inputs.csv");
    FILE *expected = opened((count > 2) ? words[2] : "expected.csv");
    int failed = 0, rows = 0, more;
    long step = 0, k;

    begin();
    failed += wrong_answers();
    more = read_row(expected, wanted, OUTPUTS + 1);
    while (read_row(inputs, u, INPUTS)) {
        one(u, y);
        if (more && ((long)wanted[0] == step)) {
            for (k = 0; k < OUTPUTS; k++) {
                const double difference = fabs(y[k] - wanted[k + 1]);
                const int same = (y[k] == wanted[k + 1]) || ((y[k] != y[k]) && (wanted[k + 1] != wanted[k + 1]));
                const double found = same ? 0.0 : (difference >= 0.0) ? difference : HUGE_VAL;
                worst[k] = (found > worst[k]) ? found : worst[k];
                beyond[k] += (found > tolerance[k]) ? 1 : 0;
            }
            rows++;
            more = read_row(expected, wanted, OUTPUTS + 1);
        }
        step++;
    }
    for (k = 0; k < OUTPUTS; k++) {
        if ((double)beyond[k] > (ROWS_BEYOND * (double)rows)) {
            (void)printf("%s differs by up to %g, beyond %g in %ld rows\n", names[k], worst[k], tolerance[k], beyond[k]);
            failed++;
        }
    }
    (void)printf("%s: %ld steps, %d compared, %d of %d outputs beyond tolerance\n", version(), step, rows, failed, OUTPUTS);
    return ((failed > 0) || (rows == 0)) ? 1 : 0;
}
#endif
