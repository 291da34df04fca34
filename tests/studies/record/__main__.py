from tests.studies.record import main

main()
