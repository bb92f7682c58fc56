# The reference figure by gnuplot: gnuplot -e "kind='pngcairo size 1200,800'; out='a.png'; data='steps.txt'" noisy_steps.gp
eval "set terminal ".kind
set output out
set title "Step responses for five dampings, with sensor noise"
set xlabel "time t [s]"
set ylabel "output y [m]"
set grid
plot for [i=2:6] data using 1:i with lines title sprintf("%d", i)
