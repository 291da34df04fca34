from docs.studies.record import main

main()
